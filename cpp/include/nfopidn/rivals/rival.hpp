// L4. What the rival controllers have in common: the interface of the NFOPIDN controller, the
// reference torques, the limit, and where the speeds come from that these laws need.
#pragma once

#include "nfopidn/control/reference.hpp"
#include "nfopidn/firmware/velocity_output.hpp"

namespace nfopidn::rivals {

// Where v and omega come from: NFOPIDN sees the pose alone, and a fair comparison is both ways.
enum class Speeds : unsigned char {
  measured,     // those of Measurement
  differenced,  // from the last two poses
};

// What a law is built for. Its torques come from this model of the robot, not from the true one.
template <class Scalar>
struct Model {
  Robot<Scalar> robot;
  Scalar dt;          // [s]
  Scalar peak_speed;  // the reference's largest |v| [m/s]
};

template <class Scalar>
struct Accelerations {
  Scalar linear;   // [m/s^2]
  Scalar angular;  // [rad/s^2]
};

// What a law is shown at a sample.
template <class Scalar>
struct View {
  Channels<Scalar> error;  // reference minus measured, in the robot's frame
  Velocity<Scalar> speed;  // the robot's
  const ReferenceSample<Scalar>& reference;
  Accelerations<Scalar> acceleration;  // the reference's, as its torques tell; else zero
};

// How fast the errors in the robot's frame change: the kinematics of tracking.
template <class Scalar>
constexpr Channels<Scalar> error_rates(const View<Scalar>& view) {
  const Heading<Scalar> misalignment = math<Scalar>::heading(view.error.theta);
  const auto& [v, omega] = view.speed;
  return {omega * view.error.y - v + view.reference.v * misalignment.cosine,
          view.reference.v * misalignment.sine - omega * view.error.x,
          view.reference.omega - omega};
}

// Speeds between two poses: the way along the mean heading, over the time.
template <class Scalar>
class SpeedEstimate {
 public:
  explicit constexpr SpeedEstimate(Scalar dt) : rate_(Scalar(1) / dt) {}

  constexpr void reset() noexcept { first_ = true; }

  // At the first sample the robot is taken to be at rest.
  constexpr Velocity<Scalar> next(const Measurement<Scalar>& now) noexcept {
    using M = math<Scalar>;
    const Scalar turn = M::wrap(now.theta - last_.theta);
    const Heading<Scalar> mean = M::heading(last_.theta + turn * Scalar(0.5));
    const Scalar way = (now.x - last_.x) * mean.cosine + (now.y - last_.y) * mean.sine;
    const Velocity<Scalar> speed = first_ ? Velocity<Scalar>{Scalar(0), Scalar(0)}
                                          : Velocity<Scalar>{way * rate_, turn * rate_};
    last_ = now;
    first_ = false;
    return speed;
  }

 private:
  Scalar rate_;
  Measurement<Scalar> last_ = {};
  bool first_ = true;
};

// A Law has Settings with fields() (see schema.hpp; the ranges are those of a search, the defaults
// what `nfopidn tune --structure NAME --seed 1` finds for the published scenario), a name, a
// Law(settings, model), reset(), and feedback(View), the accelerations that it asks for beyond the
// reference's. step() runs in constant time; it neither allocates nor throws.
template <class Law>
class Rival {
 public:
  using Scalar = typename Law::Scalar;
  using Base = Scalar;

  Rival(const typename Law::Settings& settings, const Model<Scalar>& model, Scalar torque_limit,
        Speeds speeds)
      : law_(settings, model),
        robot_(model.robot),
        dynamics_(model.robot),
        estimate_(model.dt),
        limit_(torque_limit),
        speeds_(speeds) {}

  constexpr void reset() noexcept {
    law_.reset();
    estimate_.reset();
    feedback_ = {Scalar(0), Scalar(0)};
  }

  // The limited total torque. Call once a sample.
  constexpr TorquePair<Scalar> step(const Measurement<Scalar>& measured,
                                    const ReferenceSample<Scalar>& reference) noexcept {
    using M = math<Scalar>;
    const Velocity<Scalar> speed = speeds_ == Speeds::measured
                                       ? Velocity<Scalar>{measured.v, measured.omega}
                                       : estimate_.next(measured);
    const TorquePair<Scalar> own = {reference.tau_left, reference.tau_right};
    const Disturbance<Scalar> calm = {Scalar(0), Scalar(0)};
    const Accelerations<Scalar> wanted = law_.feedback(
        {rotate_into_robot(world_errors(measured, reference), M::heading(measured.theta)),
         speed,
         reference,
         {dynamics_.linear(own, calm), dynamics_.angular(own, calm)}});
    feedback_ = inverse_dynamics(robot_, wanted.linear, wanted.angular);
    return {limited(feedback_.left + own.left), limited(feedback_.right + own.right)};
  }

  // The unlimited feedback part of the last step's torque.
  constexpr TorquePair<Scalar> feedback() const noexcept { return feedback_; }
  constexpr const Law& law() const noexcept { return law_; }

 private:
  constexpr Scalar limited(Scalar torque) const {
    return math<Scalar>::maximum(math<Scalar>::minimum(torque, limit_), -limit_);
  }

  Law law_;
  Robot<Scalar> robot_;
  Acceleration<Scalar> dynamics_;
  SpeedEstimate<Scalar> estimate_;
  Scalar limit_;
  Speeds speeds_;
  TorquePair<Scalar> feedback_ = {Scalar(0), Scalar(0)};
};

}  // namespace nfopidn::rivals

namespace nfopidn {

template <>
struct ChoiceNames<rivals::Speeds> {
  static constexpr const char* names[] = {"measured", "differenced"};
};

}  // namespace nfopidn
