// The tracking law: costs of an independent implementation, and its equations one by one.
#include <fstream>
#include <nlohmann/json.hpp>

#include "nfopidn/analysis/floquet.hpp"
#include "nfopidn/tuning/tune.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

ControllerDesign tracking_controller(const nlohmann::json& p) {
  ControllerDesign design;
  for (auto& row : design.gains) std::fill(std::begin(row), std::end(row), 0.0);
  design.gains[0][0] = p.at("kp_x");
  design.gains[1][0] = p.at("kp_y");
  design.gains[2][0] = p.at("kp_theta");
  design.allocation = Allocation<double>::decoupled();
  design.lateral = Lateral::scheduled;
  design.net = Net::speed_errors;
  design.speed_gain_x = p.at("kd_x");
  design.speed_gain_theta = p.at("kd_theta");
  design.speed_order_x = p.at("alpha_x");
  design.speed_order_theta = p.at("alpha_theta");
  design.amplitude_x = p.at("amplitude_x");
  design.amplitude_y = p.at("amplitude_y");
  design.amplitude_theta = p.at("amplitude_theta");
  design.pole_x = p.value("pole_x", 0.0);
  design.pole_theta = p.value("pole_theta", 0.0);
  design.integral_x = p.at("integral_x");
  design.integral_y = p.at("integral_y");
  design.integral_theta = p.at("integral_theta");
  design.integral_retention = p.at("leak");
  design.integral_limit = p.at("integral_limit");
  design.lateral_speed = p.at("lateral_speed");
  design.lateral_power = p.at("lateral_power");
  return design;
}

Scenario on_path(const std::string& path, bool fast) {
  TrajectorySettings settings;
  const auto set = [&](Curve curve, double period) {
    settings.name = curve;
    settings.period = period;
  };
  if (path == "ran" || path == "ranc") set(Curve::ranunculoid, 150);
  if (path == "five") set(Curve::ranunculoid, 240);
  if (path == "circle") set(Curve::circle, 45);
  if (path == "lemn") set(Curve::lemniscate, 45);
  if (path == "eight") set(Curve::eight, 60);
  if (path == "sine") set(Curve::sine, 30);
  if (path == "square") set(Curve::rounded_square, 60);
  if (path == "line") set(Curve::line, 20);
  if (path == "five") settings.cusps = 5;
  if (path == "ranc") settings.heading = HeadingChoice::continuous;
  if (fast) settings.period /= 3;
  Scenario scenario;
  make_trajectory(settings, scenario.trajectory);
  const Trajectory& t = scenario.trajectory;
  scenario.initial_pose = {t.x(0), t.y(0) + 0.3, t.theta(0)};
  return scenario;
}

Scenario golden_scenario(const std::string& name) {
  const std::size_t slash = name.find('/');
  std::string path = name.substr(2, slash - 2);
  const std::string condition = name.substr(slash + 1);
  Scenario scenario;
  if (name[0] == 'R') {
    TrajectorySettings settings;
    if (path != "P") settings.heading = HeadingChoice::continuous;
    if (path == "F") settings.period = 50;
    make_trajectory(settings, scenario.trajectory);
    scenario.initial_pose = {4.0, 0.0, 1.0472};
  } else {
    const std::size_t fast = path.find("-fast");
    scenario = on_path(path.substr(0, fast), fast != std::string::npos);
  }
  if (condition == "sub4") scenario.substeps = 4;
  if (condition == "m+20") scenario.robot.mass = 13.8;
  if (condition == "m-20") scenario.robot.mass = 9.2;
  if (condition == "I.294") scenario.robot.inertia = 0.294;
  if (condition == "L.39") scenario.robot.track_width = 0.39;
  if (condition == "delay") scenario.delay = 1;
  return scenario;
}

TEST(TrackingLaw, HasTheCostsOfAnIndependentImplementation) {
  const auto golden =
      nlohmann::json::parse(std::ifstream(std::string(NFOPIDN_GOLDEN) + "/tracking_costs.json"));
  int cases = 0;
  for (const auto& [set, costs] : golden.at("costs").items()) {
    const ControllerDesign design = tracking_controller(golden.at("parameters").at(set));
    for (const auto& [name, cost] : costs.items()) {
      const Scenario scenario = golden_scenario(name);
      const double expected = cost;
      EXPECT_NEAR(simulate(scenario, design).metrics.cost / expected, 1.0, 1e-8)
          << set << " " << name;
      ++cases;
    }
  }
  EXPECT_EQ(cases, 228);
}

// Lanes and dual numbers run the same law: costs as simulate()'s, slopes as differences of costs.
TEST(TrackingLaw, IsTheSameInLanesAndInDualNumbers) {
  const auto golden =
      nlohmann::json::parse(std::ifstream(std::string(NFOPIDN_GOLDEN) + "/tracking_costs.json"));
  const ControllerDesign design = tracking_controller(golden.at("parameters").at("recommended"));
  for (const char* name : {"R:P/nom", "R:F/delay", "G:sine/nom"}) {
    Scenario scenario = golden_scenario(name);
    for (const double noise : {0.0, 0.005}) {
      scenario.pose_noise = {noise, noise};
      Structure structure = named_structure(StructureName::tracking);
      std::vector<double> x = parameters_of(structure.parameters, design);
      ASSERT_EQ(x.size(), 19U);
      const int count = static_cast<int>(x.size());
      TuneObjective objective({&scenario}, ParameterSpace::whole(structure), 1, 1);
      const Point point = Eigen::Map<const Point>(x.data(), count);
      const double cost = simulate(scenario, design).metrics.cost;
      Points around = point.replicate(1, 2 * count + 1);
      for (Eigen::Index i = 0; i < count; ++i) {
        const double step = 1e-6 * std::max(0.01, std::fabs(point(i)));
        around(i, 2 * i) += step;
        around(i, 2 * i + 1) -= step;
      }
      Eigen::VectorXd costs(around.cols());
      objective.costs(around, costs.data());
      EXPECT_NEAR(costs(2 * count) / cost, 1, 1e-11) << name << " " << noise;
      Eigen::VectorXd slopes(count);
      EXPECT_NEAR(objective.gradient(point, slopes.data()) / cost, 1, 1e-11) << name;
      for (Eigen::Index i = 0; i < count; ++i) {
        const double width = around(i, 2 * i) - around(i, 2 * i + 1);
        const double difference = (costs(2 * i) - costs(2 * i + 1)) / width;
        EXPECT_NEAR(slopes(i), difference, 1e-5 * std::fabs(difference) + 1e-6)
            << name << " parameter " << i;
      }
    }
  }
}

// The loop as a map, from the state that a run has after its first sample.
TEST(TrackingLaw, RunsAsAMapAsTheSimulationDoes) {
  const auto golden =
      nlohmann::json::parse(std::ifstream(std::string(NFOPIDN_GOLDEN) + "/tracking_costs.json"));
  const ControllerDesign design = tracking_controller(golden.at("parameters").at("recommended"));
  Scenario scenario = golden_scenario("R:C/delay");
  const RunTable table = simulate(scenario, design).table;
  const PreparedRun run = prepare(scenario);
  const PeriodicReference reference = {run.reference, 300, 1};
  StepMap<double> map(run, design, reference);
  // At rest before the first sample: the last pose was this one, and no speed error is remembered.
  // The reference's motion is then the whole error of the second sample.
  Eigen::VectorXd z = Eigen::VectorXd::Zero(map.size()), next(map.size());
  const auto error_of = [&](int k) {
    const double c = std::cos(table(k, column_e_theta));
    const double s = std::sin(table(k, column_e_theta));
    return std::array<double, 3>{c * table(k, column_e_x) + s * table(k, column_e_y),
                                 c * table(k, column_e_y) - s * table(k, column_e_x),
                                 table(k, column_e_theta)};
  };
  for (int i = 0; i < 3; ++i) {
    z(i) = z(map.states().tracking() + i) = error_of(0)[static_cast<std::size_t>(i)];
  }
  for (int k = 0; k < reference.period; ++k) {
    for (int i = 0; i < 3; ++i) {
      ASSERT_NEAR(z(i), error_of(k)[static_cast<std::size_t>(i)], 1e-9) << k << ", " << i;
    }
    map.advance(k, z.data(), next.data());
    z = next;
  }
}

// The largest multiplier of a stable loop tells how fast a run comes back to its path.
TEST(TrackingLaw, IsStableOnItsCircleWithTheDecayThatASimulationHas) {
  const auto golden =
      nlohmann::json::parse(std::ifstream(std::string(NFOPIDN_GOLDEN) + "/tracking_costs.json"));
  const ControllerDesign design = tracking_controller(golden.at("parameters").at("recommended"));
  Scenario scenario;
  TrajectorySettings settings;
  settings.name = Curve::circle;
  settings.period = 45;
  settings.laps = 40;
  make_trajectory(settings, scenario.trajectory);
  LoopStability found;
  ASSERT_EQ(analyse_loop(scenario, design, found).message, "");
  ASSERT_TRUE(found.orbit.found);
  ASSERT_EQ(found.reference.period, 1);
  const double radius = std::exp(found.log_radius);
  EXPECT_LT(radius, 1);
  const Trajectory& t = scenario.trajectory;
  scenario.initial_pose = {t.x(0) + 0.01, t.y(0), t.theta(0)};
  scenario.initial_velocity.reference = true;
  const RunTable off = simulate(scenario, design).table;
  scenario.initial_pose = {t.x(0), t.y(0), t.theta(0)};
  const RunTable on = simulate(scenario, design).table;
  // The largest distance in one swing of the complex multiplier, and in the next one.
  const double angle = std::fabs(std::arg(found.multipliers(0)));
  const int swing = static_cast<int>(std::lround(2 * std::acos(-1.0) / angle));
  const auto apart = [&](int from) {
    double most = 0;
    for (int k = from; k < from + swing; ++k) {
      most = std::max(
          most, std::hypot(off(k, column_x) - on(k, column_x), off(k, column_y) - on(k, column_y)));
    }
    return most;
  };
  EXPECT_NEAR(std::pow(apart(400 + swing) / apart(400), 1.0 / swing), radius, 2e-4);
}

}  // namespace
}  // namespace nfopidn::test
