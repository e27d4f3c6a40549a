// What holds for every plant, and the motors against closed forms.
#include "nfopidn/loop/closed_loop.hpp"
#include "nfopidn/math/dual.hpp"
#include "nfopidn/plant/robot_drive.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

const Robot<double> base_robot = Robot<double>::eddie_datasheet();
const Motor<double> some_motor = {2.4, 0.012, 0.011, 30, 2e-6, 0.003, 0, 24};

struct Torques {
  using Plant = DifferentialDrive<double>;
  static constexpr double size_of_input = 0.7;  // [N m]
  static Plant make(Integrator integrator, double span, int substeps = 1) {
    return {base_robot, {0.02, 0}, integrator, span, substeps};
  }
};
struct Voltages {
  using Plant = MotorDrive<double>;
  static constexpr double size_of_input = 6;  // [V]
  static Plant make(Integrator integrator, double span, int substeps = 1) {
    return {base_robot, some_motor, integrator, span, substeps};
  }
};

// Torques as a scenario has them: by motors.
struct Commands {
  using Plant = RobotDrive<double>;
  static constexpr double size_of_input = 0.4;  // [N m]
  static Plant make(Integrator integrator, double span, int substeps = 1) {
    return {base_robot, {0.02, 0}, &some_motor, integrator, span, substeps};
  }
};

template <class Kind>
class Plants : public ::testing::Test {
 protected:
  using Plant = typename Kind::Plant;
  State<double> moved(const Plant& plant, State<double> state, TorquePair<double> input) const {
    plant.advance(state, Plant::heading(state), input);
    return state;
  }
  const State<double> start{0.4, -0.2, 0.9, 0.3, -0.5};
};
using Kinds = ::testing::Types<Torques, Voltages, Commands>;
TYPED_TEST_SUITE(Plants, Kinds);

TYPED_TEST(Plants, AreOnesInEveryScalar) {
  using Tested = typename TypeParam::Plant;
  EXPECT_TRUE((is_plant<Tested, double>));
  EXPECT_TRUE((is_plant<Tested, Dual<double>>));
  EXPECT_FALSE((is_plant<Robot<double>, double>));
  EXPECT_EQ(Tested::size * sizeof(double), sizeof(State<double>));
}

TYPED_TEST(Plants, HaveParametersWithinTheirRanges) {
  int parameters = 0;
  TypeParam::Plant::Parameters::fields([&](const auto& field) {
    EXPECT_GT(std::string(field.text).size(), 5U) << field.name;
    ++parameters;
  });
  EXPECT_GE(parameters, 4);
  EXPECT_EQ((typename TypeParam::Plant::Parameters{}.validate()), Status::ok);
}

// The inverse's input, applied for a moment, gives the accelerations.
TYPED_TEST(Plants, InverseGivesTheAccelerations) {
  constexpr double moment = 1e-6;
  const auto plant = TypeParam::make(Integrator::exact, moment);
  Draws draw{17};
  for (int trial = 0; trial < 50; ++trial) {
    const State<double> state = {0, 0, draw.scalar<double>(-3, 3), draw.scalar<double>(-1, 1),
                                 draw.scalar<double>(-1, 1)};
    const double linear = draw.scalar<double>(-0.3, 0.3);
    const double angular = draw.scalar<double>(-0.3, 0.3);
    const State<double> after = this->moved(plant, state, plant.inverse(state, linear, angular));
    EXPECT_NEAR((after.v - state.v) / moment, linear, 1e-5);
    EXPECT_NEAR((after.omega - state.omega) / moment, angular, 1e-5);
  }
}

TYPED_TEST(Plants, HeadingIsThatOfTheState) {
  const Heading<double> heading = TypeParam::Plant::heading(this->start);
  EXPECT_NEAR(heading.cosine, std::cos(this->start.theta), 1e-12);
  EXPECT_NEAR(heading.sine, std::sin(this->start.theta), 1e-12);
}

// Equal inputs of opposite sign in the paper's sense: the left one turns counter-clockwise.
TYPED_TEST(Plants, TheLeftInputTurnsCounterClockwise) {
  const auto plant = TypeParam::make(Integrator::exact, 0.1);
  const double input = TypeParam::size_of_input;
  const State<double> rest = {0, 0, 0, 0, 0};
  const State<double> turned = this->moved(plant, rest, {input, -input});
  EXPECT_GT(turned.omega, 0.01);
  EXPECT_NEAR(turned.v, 0, 1e-12);
  const State<double> driven = this->moved(plant, rest, {input, input});
  EXPECT_GT(driven.v, 0.01);
  EXPECT_NEAR(driven.omega, 0, 1e-12);
}

TYPED_TEST(Plants, FineStepsAndTheExactIntegratorAgree) {
  const double input = TypeParam::size_of_input;
  const auto exact = TypeParam::make(Integrator::exact, 0.2);
  const auto fine = TypeParam::make(Integrator::semi_implicit_euler, 0.2, 200000);
  const State<double> a = this->moved(exact, this->start, {input, -0.3 * input});
  const State<double> b = this->moved(fine, this->start, {input, -0.3 * input});
  EXPECT_NEAR(a.x, b.x, 1e-5);
  EXPECT_NEAR(a.y, b.y, 1e-5);
  EXPECT_NEAR(a.theta, b.theta, 1e-5);
  EXPECT_NEAR(a.v, b.v, 1e-5);
  EXPECT_NEAR(a.omega, b.omega, 1e-5);
}

// A law that pushes back in proportion to what the plant's inverse says is missing.
template <class Plant>
struct Follower {
  const Plant* plant;
  TorquePair<double> step(const Measurement<double>& measured,
                          const ReferenceSample<double>& reference) {
    const State<double> state = {measured.x, measured.y, measured.theta, measured.v,
                                 measured.omega};
    const double missing = reference.x - measured.x;
    return plant->inverse(state, 4 * missing - 4 * measured.v, -4 * measured.omega);
  }
};

TYPED_TEST(Plants, RunInTheClosedLoop) {
  const auto plant = TypeParam::make(Integrator::exact, 0.02);
  const std::vector<ReferenceSample<double>> reference(500, {1, 0, 0, 0, 0, 0, 0, false});
  LoopInputs<double> inputs;
  inputs.reference = reference.data();
  inputs.samples = 500;
  Follower<typename TypeParam::Plant> law{&plant};
  LoopState<double> loop{{0, 0, 0, 0, 0}, DelayLine<double>(0)};
  const LoopResult<double> result = run_closed_loop<double>(
      plant, law, loop, inputs, [](int, const auto&, const auto&, const auto&) {});
  EXPECT_EQ(result.completed, 500);
  EXPECT_NEAR(loop.robot.x, 1, 1e-3);
  EXPECT_NEAR(loop.robot.v, 0, 1e-3);
}

// --- The motors ---

// m v' = 2 N k_t (V - N k_e v / r) / (R r) - 2 b v / r^2, of which the solution is an exponential.
TEST(MotorDrive, SpeedsUpAsItsEquationSays) {
  const double r = base_robot.wheel_radius;
  const double n = some_motor.gear_ratio;
  const double mass = base_robot.mass + 2 * n * n * some_motor.rotor_inertia / (r * r);
  const double push = 2 * n * some_motor.torque_constant / (some_motor.resistance * r);  // [N/V]
  const double drag =
      2 / (r * r) *
      (n * n * some_motor.torque_constant * some_motor.back_emf_constant / some_motor.resistance +
       some_motor.viscous_friction);  // [N s/m]
  const double volts = 7;
  for (const double span : {0.01, 0.1, 1.0, 5.0}) {
    const MotorDrive<double> plant(base_robot, some_motor, Integrator::exact, span, 1);
    State<double> state = {0, 0, 0, 0, 0};
    plant.advance(state, {1.0, 0.0}, TorquePair<double>{volts, volts});
    EXPECT_NEAR(state.v, push * volts / drag * (1 - std::exp(-drag / mass * span)), 1e-12);
  }
}

TEST(MotorDrive, TurnsAsItsEquationSays) {
  const double r = base_robot.wheel_radius;
  const double half = base_robot.track_width / 2;
  const double n = some_motor.gear_ratio;
  const double inertia =
      base_robot.inertia + 2 * n * n * some_motor.rotor_inertia * half * half / (r * r);
  const double push = 2 * half * n * some_motor.torque_constant / (some_motor.resistance * r);
  const double drag =
      2 * half * half / (r * r) *
      (n * n * some_motor.torque_constant * some_motor.back_emf_constant / some_motor.resistance +
       some_motor.viscous_friction);
  const MotorDrive<double> plant(base_robot, some_motor, Integrator::exact, 0.3, 1);
  State<double> state = {0, 0, 0, 0, 0};
  plant.advance(state, {1.0, 0.0}, TorquePair<double>{3, -3});
  EXPECT_NEAR(state.omega, push * 3 / drag * (1 - std::exp(-drag / inertia * 0.3)), 1e-12);
}

// At the no-load speed of an ideal motor back EMF equals the voltage.
TEST(MotorDrive, NoLoadSpeedIsWhereBackEmfIsTheVoltage) {
  Motor<double> ideal = some_motor;
  ideal.viscous_friction = 0;
  const MotorDrive<double> plant(base_robot, ideal, Integrator::exact, 100, 1);
  State<double> state = {0, 0, 0, 0, 0};
  plant.advance(state, {1.0, 0.0}, TorquePair<double>{6, 6});
  EXPECT_NEAR(state.v / base_robot.wheel_radius * ideal.gear_ratio * ideal.back_emf_constant, 6,
              1e-9);
}

TEST(MotorDrive, AppliesNoMoreThanTheSupply) {
  const MotorDrive<double> plant(base_robot, some_motor, Integrator::exact, 0.1, 1);
  State<double> limited = {0, 0, 0, 0, 0}, full = limited;
  plant.advance(limited, {1.0, 0.0}, TorquePair<double>{1000, -1000});
  plant.advance(full, {1.0, 0.0},
                TorquePair<double>{some_motor.supply_voltage, -some_motor.supply_voltage});
  EXPECT_EQ(limited.omega, full.omega);
}

TEST(MotorDrive, CoulombFrictionHoldsASmallVoltage) {
  Motor<double> stiff = some_motor;
  stiff.coulomb_friction = 0.2;
  const MotorDrive<double> plant(base_robot, stiff, Integrator::exact, 0.5, 1);
  const double breakaway = stiff.coulomb_friction / stiff.torque_per_volt();
  State<double> state = {0, 0, 0, 0, 0};
  plant.advance(state, {1.0, 0.0}, TorquePair<double>{0.99 * breakaway, 0.99 * breakaway});
  EXPECT_EQ(state.v, 0);
  plant.advance(state, {1.0, 0.0}, TorquePair<double>{1.01 * breakaway, 1.01 * breakaway});
  EXPECT_GT(state.v, 0);
}

TEST(MotorDrive, ADeadBandIsMissingFromWhatIsApplied) {
  Motor<double> swallowing = some_motor;
  swallowing.dead_band = 2;
  const MotorDrive<double> plant(base_robot, swallowing, Integrator::exact, 0.1, 1);
  const MotorDrive<double> whole(base_robot, some_motor, Integrator::exact, 0.1, 1);
  State<double> state = {0, 0, 0, 0, 0}, other = state;
  plant.advance(state, {1.0, 0.0}, TorquePair<double>{1.9, -2});
  EXPECT_EQ(state.v, 0);
  EXPECT_EQ(state.omega, 0);
  plant.advance(state, {1.0, 0.0}, TorquePair<double>{7, -5});
  whole.advance(other, {1.0, 0.0}, TorquePair<double>{5, -3});
  EXPECT_EQ(state.v, other.v);
  EXPECT_EQ(state.omega, other.omega);
}

TEST(Motor, PulseWidthsAreTheNearestCounts) {
  EXPECT_EQ(pulse_width(some_motor, 24.0, 1000), 1000);
  EXPECT_EQ(pulse_width(some_motor, -30.0, 1000), -1000);
  EXPECT_EQ(pulse_width(some_motor, 0.013, 1000), 1);
  EXPECT_EQ(pulse_width(some_motor, -0.011, 1000), 0);
}

TEST(RobotDrive, WithoutMotorsIsTheDrive) {
  const Friction<double> friction = {0.02, 0.1};
  const RobotDrive<double> plant(base_robot, friction, nullptr, Integrator::exact, 0.2, 1);
  const DifferentialDrive<double> drive(base_robot, friction, Integrator::exact, 0.2, 1);
  State<double> state = {0.4, -0.2, 0.9, 0.3, -0.5}, other = state;
  const Heading<double> heading = math<double>::heading(state.theta);
  plant.advance(state, heading, TorquePair<double>{0.3, -0.2});
  drive.advance(other, heading, TorquePair<double>{0.3, -0.2});
  EXPECT_EQ(state.x, other.x);
  EXPECT_EQ(state.omega, other.omega);
  EXPECT_FALSE(plant.has_motors());
}

TEST(RobotDrive, CommandsBecomeVoltagesByTheSpeedOfEachWheel) {
  const Friction<double> friction = {0.02, 0.1};
  const RobotDrive<double> plant(base_robot, friction, &some_motor, Integrator::exact, 0.2, 1);
  const MotorDrive<double> motors(base_robot, some_motor, Integrator::exact, 0.2, 1, friction);
  State<double> state = {0.4, -0.2, 0.9, 0.3, -0.5}, other = state;
  const Heading<double> heading = math<double>::heading(state.theta);
  const TorquePair<double> torque = {0.3, -9};
  // (v +- L omega / 2) / r, through the gear; the right motor cannot give its torque.
  const double turn = -0.5 * base_robot.track_width / 2;
  const double left = (0.3 + turn) / base_robot.wheel_radius;
  const double volts = 0.3 * 2.4 / (30 * 0.012) + 30 * 0.011 * left;
  motors.advance(other, heading, TorquePair<double>{volts, -24});
  plant.advance(state, heading, torque);
  EXPECT_NEAR(state.v, other.v, 1e-14);
  EXPECT_NEAR(state.omega, other.omega, 1e-13);
  const State<double> start = {0.4, -0.2, 0.9, 0.3, -0.5};
  const double right = (0.3 - turn) / base_robot.wheel_radius;
  EXPECT_EQ(plant.available(start, torque).left, 0.3);
  EXPECT_NEAR(plant.available(start, torque).right,
              -24 * 30 * 0.012 / 2.4 - 30 * 30 * 0.012 * 0.011 / 2.4 * right, 1e-12);
}

}  // namespace
}  // namespace nfopidn::test
