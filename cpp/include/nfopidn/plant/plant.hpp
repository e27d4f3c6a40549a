// L1. What the closed loop asks of a plant, and whether a type has it.
//
// A plant has
//   static constexpr int size         numbers of its state
//   using Parameters                  its physical parameters, with fields()
//   advance(state, heading, input, outside)   moves the state by one sample
//   inverse(state, linear, angular)   the input that gives dv/dt [m/s^2] and d(omega)/dt [rad/s^2]
//   is_exact()                        whether the integrator is the exact one
//   heading(state)                    cosine and sine of the robot's heading
// The input is a pair (left, right): torques [N m] of DifferentialDrive, voltages [V] of
// MotorDrive. The controller that runs on a plant gives its input. Of a scenario that is
// RobotDrive, which takes torques and may have motors.
#pragma once

#include "nfopidn/foundation/traits.hpp"
#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

namespace detail {

template <class Plant, class Scalar, class = void>
constexpr bool is_plant = false;
template <class Plant, class Scalar>
constexpr bool is_plant<
    Plant, Scalar,
    traits::void_t<typename Plant::Parameters,
                   decltype(traits::declval<const Plant&>().advance(
                       traits::declval<State<Scalar>&>(), traits::declval<Heading<Scalar>>(),
                       traits::declval<TorquePair<Scalar>>())),
                   decltype(traits::declval<const Plant&>().inverse(
                       traits::declval<State<Scalar>>(), traits::declval<Scalar>(),
                       traits::declval<Scalar>())),
                   decltype(traits::declval<const Plant&>().is_exact()),
                   decltype(Plant::heading(traits::declval<State<Scalar>>()))>> = Plant::size > 0;

}  // namespace detail

template <class Plant, class Scalar>
constexpr bool is_plant = detail::is_plant<Plant, Scalar>;

}  // namespace nfopidn
