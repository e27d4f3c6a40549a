// L2. Odometry in place of a measured pose: what the encoders of the wheels tell.
#pragma once

#include "nfopidn/control/reference.hpp"
#include "nfopidn/plant/odometry.hpp"

namespace nfopidn {

// The encoders of both wheels, and for what odometry takes the robot.
template <class Base>
struct Encoders {
  Base counts;              // a revolution of a wheel
  Robot<Base> robot;        // as it is
  TorquePair<Base> radius;  // of the wheels, as odometry has them [m], in the paper's sign
  Base track_width;         // as odometry has it [m]
};

// The pose by odometry, from a start that is known. Over a sample the robot's way is taken for an
// arc of a circle.
template <class Base>
class EncoderOdometry {
 public:
  using M = math<Base>;

  constexpr EncoderOdometry(const Encoders<Base>& encoders, const State<Base>& start)
      : encoders_(encoders), last_(start), pose_(start) {}

  // Once a sample: the robot's true state; returns the pose that the counts tell.
  constexpr const State<Base>& sense(const State<Base>& truth) {
    const Base half = (truth.theta - last_.theta) * Base(0.5);
    const Heading<Base> mean = M::heading(last_.theta + half);
    const Base chord = (truth.x - last_.x) * mean.cosine + (truth.y - last_.y) * mean.sine;
    const Base arc = chord * stretch(half);
    const Base turn = half * encoders_.robot.track_width;
    const Base left = counted(angle_.left, count_.left, arc + turn) * encoders_.radius.left;
    const Base right = counted(angle_.right, count_.right, arc - turn) * encoders_.radius.right;
    // The paper's left wheel is the right one of a real robot.
    pose_ = odometry(pose_, right, left, encoders_.track_width);
    last_ = truth;
    return pose_;
  }

 private:
  // An arc over its chord, with half the angle.
  static constexpr Base stretch(Base half) {
    const bool straight = half < Base(1e-4) && half > Base(-1e-4);
    if (straight) return Base(1) + half * half / Base(6);
    const Base sine = M::heading(half).sine;
    const bool more_than_a_turn = half > Base(3) || half < Base(-3);
    return more_than_a_turn ? Base(1) : half / sine;
  }

  // The angle [rad] of the counts that a wheel adds by rolling so many metres.
  constexpr Base counted(Base& angle, Base& count, Base rolled) const {
    const Base per_turn = encoders_.counts / (Base(2) * M::pi);
    angle = angle + rolled / encoders_.robot.wheel_radius;
    const Base before = count;
    count = floor(angle * per_turn);
    return (count - before) / per_turn;
  }

  // Beyond 2^53 every number is a whole one.
  static constexpr Base floor(Base value) {
    constexpr Base whole = Base(9007199254740992.0);
    if (!(value < whole && value > -whole)) return value;
    const auto towards_zero = static_cast<Base>(static_cast<long long>(value));
    return towards_zero > value ? towards_zero - Base(1) : towards_zero;
  }

  Encoders<Base> encoders_;
  State<Base> last_;
  State<Base> pose_;
  TorquePair<Base> angle_ = {Base(0), Base(0)};  // of the wheels [rad]
  TorquePair<Base> count_ = {Base(0), Base(0)};
};

}  // namespace nfopidn
