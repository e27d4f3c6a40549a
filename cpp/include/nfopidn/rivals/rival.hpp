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
template <class Base>
struct Model {
  Robot<Base> robot;
  Base dt;          // [s]
  Base peak_speed;  // the reference's largest |v| [m/s]
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
  const ReferenceSample<base_t<Scalar>>& reference;
  Accelerations<base_t<Scalar>> acceleration;  // the reference's, as its torques tell; else zero
};

// How fast the errors in the robot's frame change: the kinematics of tracking.
template <class Scalar>
NFOPIDN_INLINE constexpr Channels<Scalar> error_rates(const View<Scalar>& view) {
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
  using Base = base_t<Scalar>;

  explicit constexpr SpeedEstimate(Base dt) : rate_(Base(1) / dt) {}

  constexpr void reset() noexcept { first_ = true; }

  // At the first sample the robot is taken to be at rest.
  constexpr Velocity<Scalar> next(const Measurement<Scalar>& now) noexcept {
    using M = math<Scalar>;
    const Scalar turn = M::wrap(now.theta - last_.theta);
    const Heading<Scalar> mean = M::heading(last_.theta + turn * Base(0.5));
    const Scalar way = (now.x - last_.x) * mean.cosine + (now.y - last_.y) * mean.sine;
    const Velocity<Scalar> speed = first_ ? Velocity<Scalar>{Scalar(Base(0)), Scalar(Base(0))}
                                          : Velocity<Scalar>{way * rate_, turn * rate_};
    last_ = now;
    first_ = false;
    return speed;
  }

 private:
  Base rate_;
  Measurement<Scalar> last_ = {Scalar(Base(0)), Scalar(Base(0)), Scalar(Base(0)), Scalar(Base(0)),
                               Scalar(Base(0))};
  bool first_ = true;
};

// Fills settings with the next parameters, and gives what follows those.
template <class Settings, class Number>
constexpr const Number* take_parameters(const Number* parameters, Settings& settings) {
  Settings::fields([&](const auto& field) { settings.*field.member = *parameters++; });
  return parameters;
}

// How many parameters settings have.
template <class Settings>
constexpr int count_parameters() {
  int count = 0;
  Settings::fields([&](const auto& /*field*/) { ++count; });
  return count;
}
template <class Settings>
constexpr int parameter_count = count_parameters<Settings>();

// Integral action beside a law: it adds the sum of the accelerations that the law has asked for,
// each times a gain [1/s] and the sample time. On a loop of velocities that makes PI of P. The sums
// stay within what the torque limit can give, so that they do not wind up.
template <class Number>
struct IntegralGains {
  Number k_i_v = Number(0.0);
  Number k_i_omega = Number(0.0);

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    visit(field("k_i_v", &IntegralGains::k_i_v, "1/s", between(0, 5),
                "of the integral of the acceleration along"));
    visit(field("k_i_omega", &IntegralGains::k_i_omega, "1/s", between(0, 5),
                "of the integral of the turning acceleration"));
  }
};

// A Law has Settings with fields() (see schema.hpp; the ranges are those of a search, the defaults
// what `nfopidn tune --structure NAME --seed 1` finds for the published scenario), a name, a
// Law(settings, model), reset(), and feedback(View), the accelerations that it asks for beyond the
// reference's. step() runs in constant time; it neither allocates nor throws.
template <class Law, bool with_integral = false>
class Rival {
 public:
  using Scalar = typename Law::Scalar;
  using Base = base_t<Scalar>;

  Rival(const Law& law, const Model<Base>& model, Base torque_limit, Speeds speeds,
        const IntegralGains<Scalar>& integral = {})
      : law_(law),
        robot_(model.robot),
        dynamics_(model.robot),
        estimate_(model.dt),
        limit_(torque_limit),
        speeds_(speeds),
        rate_{integral.k_i_v * model.dt, integral.k_i_omega * model.dt},
        most_{Base(2) * torque_limit * dynamics_.drive, Base(2) * torque_limit * dynamics_.steer} {}

  constexpr void reset() noexcept {
    law_.reset();
    estimate_.reset();
    feedback_ = {Scalar(Base(0)), Scalar(Base(0))};
    sum_ = {Scalar(Base(0)), Scalar(Base(0))};
  }

  // The limited total torque. Call once a sample.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> step(
      const Measurement<Scalar>& measured, const ReferenceSample<Base>& reference) noexcept {
    using M = math<Scalar>;
    const Velocity<Scalar> speed = speeds_ == Speeds::measured
                                       ? Velocity<Scalar>{measured.v, measured.omega}
                                       : estimate_.next(measured);
    const TorquePair<Base> own = {reference.tau_left, reference.tau_right};
    const Disturbance<Base> calm = {Base(0), Base(0)};
    Accelerations<Scalar> wanted = law_.feedback(
        {rotate_into_robot(world_errors(measured, reference), M::heading(measured.theta)),
         speed,
         reference,
         {dynamics_.linear(own, calm), dynamics_.angular(own, calm)}});
    if constexpr (with_integral) {
      sum_ = {within(sum_.linear + wanted.linear * rate_.linear, most_.linear),
              within(sum_.angular + wanted.angular * rate_.angular, most_.angular)};
      wanted = {wanted.linear + sum_.linear, wanted.angular + sum_.angular};
    }
    feedback_ = inverse_dynamics(robot_, wanted.linear, wanted.angular);
    return {within(feedback_.left + own.left, limit_), within(feedback_.right + own.right, limit_)};
  }

  // The unlimited feedback part of the last step's torque.
  constexpr TorquePair<Scalar> feedback() const noexcept { return feedback_; }

  // From the next step on; what is remembered stays.
  constexpr void set_torque_limit(Base limit) noexcept {
    limit_ = limit;
    most_ = {Base(2) * limit * dynamics_.drive, Base(2) * limit * dynamics_.steer};
  }

 private:
  NFOPIDN_INLINE static constexpr Scalar within(const Scalar& value, Base limit) {
    return math<Scalar>::maximum(math<Scalar>::minimum(value, Scalar(limit)), Scalar(-limit));
  }

  Law law_;
  Robot<Base> robot_;
  Acceleration<Base> dynamics_;
  SpeedEstimate<Scalar> estimate_;
  Base limit_;
  Speeds speeds_;
  Accelerations<Scalar> rate_;
  Accelerations<Base> most_;
  Accelerations<Scalar> sum_ = {Scalar(Base(0)), Scalar(Base(0))};
  TorquePair<Scalar> feedback_ = {Scalar(Base(0)), Scalar(Base(0))};
};

}  // namespace nfopidn::rivals

namespace nfopidn {

template <>
struct ChoiceNames<rivals::Speeds> {
  static constexpr const char* names[] = {"measured", "differenced"};
};

}  // namespace nfopidn
