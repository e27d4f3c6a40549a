// Every field of every settings struct changes the run: a knob that turns nothing is a fault, and
// so is a field that no test turns.
#include <set>

#include "support.hpp"

namespace nfopidn::test {
namespace {

using Settings = ControllerSettings<double>;

// Costs of one field's turns must differ from the base's and from each other.
class DistinctCosts {
 public:
  void add(const std::string& field, double base, double turned) {
    std::set<double>& costs = costs_[field];
    costs.insert(base);
    EXPECT_TRUE(std::isfinite(turned)) << field;
    EXPECT_TRUE(costs.insert(turned).second) << field << " turned for the " << costs.size()
                                             << "th time, and the cost is again " << turned;
  }

 private:
  std::map<std::string, std::set<double>> costs_;
};

// One turn for each number of an array, found anew in the settings that are turned.
template <class Numbers>
auto each_number(int count, Numbers numbers, double change) {
  std::vector<std::function<void(Settings&)>> turns;
  for (int i = 0; i < count; ++i) {
    turns.push_back([=](Settings& s) { numbers(s)[i] += change * (1 + 0.1 * i); });
  }
  return turns;
}

// The tracking law with every part of it in action.
void track(Settings& s) {
  s = steady_settings(Form::positional);
  for (auto& row : s.gains) std::fill(std::begin(row), std::end(row), 0.0);
  s.gains[0][0] = 2;
  s.gains[1][0] = 0.3;
  s.gains[2][0] = 0.9;
  s.allocation = Allocation<double>::decoupled();
  s.net = Net::speed_errors;
  s.lateral = Lateral::scheduled;
  s.speed_gain_x = 9;
  s.speed_gain_theta = 2;
  s.integral_x = 0.05;
  s.integral_theta = 0.01;
  s.integral_retention = 0.99;
  s.integral_limit = 0.05;
}

void add_tracking_knobs(Knobs<Settings>& knobs) {
  const auto add = [&](const char* name, double Settings::*member, double change) {
    knobs[name].turns = {[=](Settings& s) { s.*member += change; },
                         [=](Settings& s) { s.*member += 2 * change; }};
    knobs[name].given = track;
  };
  knobs["net"].turns = {[](Settings& s) { s.net = Net::whole; },
                        [](Settings& s) {
                          s.net = Net::speed_errors;
                          s.speed_gain_x = 0.5;
                        }};
  knobs["net"].given = [](Settings& s) {
    for (const int channel : {0, 2}) s.gains[channel][1] = s.gains[channel][2] = 0;
  };
  add("speed_gain_x", &Settings::speed_gain_x, 0.5);
  add("speed_gain_theta", &Settings::speed_gain_theta, 0.2);
  add("speed_order_x", &Settings::speed_order_x, 0.1);
  add("speed_order_theta", &Settings::speed_order_theta, 0.1);
  add("amplitude_x", &Settings::amplitude_x, 0.2);
  add("amplitude_y", &Settings::amplitude_y, -0.4);
  add("amplitude_theta", &Settings::amplitude_theta, 0.2);
  add("pole_x", &Settings::pole_x, 0.1);
  add("pole_theta", &Settings::pole_theta, 0.1);
  add("integral_x", &Settings::integral_x, 0.02);
  add("integral_y", &Settings::integral_y, 0.02);
  add("integral_theta", &Settings::integral_theta, 0.02);
  add("integral_retention", &Settings::integral_retention, -0.05);
  add("integral_limit", &Settings::integral_limit, -0.02);
  add("lateral_speed", &Settings::lateral_speed, 0.1);
  add("lateral_power", &Settings::lateral_power, 0.2);
}

Knobs<Settings> controller_knobs() {
  Knobs<Settings> knobs;
  knobs["gains"].turns = each_number(
      9, [](Settings& s) { return &s.gains[0][0]; }, 0.02);
  knobs["alpha"].turns = each_number(
      3, [](Settings& s) { return s.alpha; }, 0.02);
  knobs["sigma"].turns = each_number(
      3, [](Settings& s) { return s.sigma; }, 0.02);
  knobs["memory"].turns = {[](Settings& s) { s.memory = 4; }, [](Settings& s) { s.memory = 6; },
                           [](Settings& s) { s.memory = 12; }};
  knobs["form"].turns = all_choices(&Settings::form);
  knobs["allocation"].turns = each_number(
      6, [](Settings& s) { return &s.allocation.matrix[0][0]; }, 0.02);
  knobs["activation"].turns = all_choices(&Settings::activation);
  knobs["frame"].turns = all_choices(&Settings::frame);
  knobs["generator"].turns = all_choices(&Settings::generator);
  knobs["lateral"].turns = all_choices(&Settings::lateral);
  knobs["lateral"].given = [](Settings& s) { s.lateral = Lateral::plain; };
  knobs["speed_scale"].turns = {[](Settings& s) { s.speed_scale = 0.5; }};
  knobs["speed_scale"].given = [](Settings& s) { s.lateral = Lateral::speed; };
  knobs["sample_time"].turns = {[](Settings& s) { s.sample_time = 0.1; }};
  knobs["anti_windup"].turns = all_choices(&Settings::anti_windup);
  knobs["anti_windup"].given = [](Settings& s) { s = steady_settings(Form::incremental); };
  add_tracking_knobs(knobs);
  return knobs;
}

TEST(Knobs, EveryControllerSettingChangesTheCost) {
  DistinctCosts costs;
  turn_every_knob(steady_settings(Form::positional), controller_knobs(),
                  [&](const std::string& field, const Settings& base, const Settings& turned) {
                    Scenario scenario = short_scenario();
                    if (field == "anti_windup") scenario.torque_limit = 0.05;
                    if (field == "sample_time") {  // it decides whether there is a run
                      EXPECT_EQ(check_run(scenario, base), Status::ok);
                      EXPECT_EQ(check_run(scenario, turned), Status::inconsistent);
                      return;
                    }
                    EXPECT_EQ(turned.validate(), Status::ok) << field;
                    const PreparedRun run = prepare(scenario);
                    costs.add(field, evaluate(run, base), evaluate(run, turned));
                  });
}

TEST(Knobs, TheBasesOfTheControllerKnobsDoNotDiverge) {
  for (const Form form : {Form::positional, Form::incremental}) {
    EXPECT_FALSE(simulate(short_scenario(), steady_settings(form)).diverged);
  }
}

TEST(Knobs, EveryTrajectorySettingChangesTheCost) {
  using T = TrajectorySettings;
  TrajectorySettings start = short_scenario().trajectory.settings;
  start.heading = HeadingChoice::forward;
  Knobs<T> knobs;
  for (int curve = 1; curve < static_cast<int>(Curve::samples); ++curve) {
    knobs["name"].turns.push_back([=](T& t) { t.name = static_cast<Curve>(curve); });
  }
  knobs["period"].turns = {[](T& t) { t.period = 31; }};
  knobs["dt"].turns = {[](T& t) { t.dt = 0.19; }};
  knobs["cusps"].turns = {[](T& t) { t.cusps = 4; }, [](T& t) { t.cusps = 5; }};
  knobs["heading"].turns = all_choices(&T::heading);
  knobs["scale"].turns = {[](T& t) { t.scale = 0.51; }};
  knobs["laps"].turns = {[](T& t) { t.laps = 2; }};
  knobs["derivatives"].turns = all_choices(&T::derivatives);
  knobs["standstill_speed"].turns = {[](T& t) { t.standstill_speed = 0.1; }};
  DistinctCosts costs;
  const auto cost = [](const T& settings) {
    Scenario scenario;
    scenario.trajectory = make(settings);
    return simulate(scenario, steady_settings(Form::positional)).metrics.cost;
  };
  turn_every_knob(start, knobs, [&](const std::string& field, const T& base, const T& turned) {
    costs.add(field, cost(base), cost(turned));
  });
}

TEST(Knobs, EveryRobotParameterChangesTheCost) {
  using R = Robot<double>;
  Knobs<R> knobs;
  knobs["mass"].turns = {[](R& r) { r.mass *= 1.1; }};
  knobs["inertia"].turns = {[](R& r) { r.inertia *= 1.1; }};
  knobs["track_width"].turns = {[](R& r) { r.track_width *= 1.1; }};
  knobs["wheel_radius"].turns = {[](R& r) { r.wheel_radius *= 1.1; }};
  DistinctCosts costs;
  const auto cost = [](const R& robot) {
    Scenario scenario = short_scenario();
    scenario.robot = robot;
    return simulate(scenario, steady_settings(Form::positional)).metrics.cost;
  };
  turn_every_knob(R::eddie(), knobs, [&](const std::string& field, const R& base, const R& turned) {
    costs.add(field, cost(base), cost(turned));
  });
}

Knobs<Scenario> scenario_knobs() {
  using S = Scenario;
  Knobs<S> knobs;
  knobs["initial_pose"].turns = {[](S& s) { s.initial_pose.reset(); }};
  for (std::size_t i = 0; i < 3; ++i) {
    knobs["initial_pose"].turns.push_back([=](S& s) { (*s.initial_pose)[i] += 0.05; });
  }
  knobs["initial_velocity"].turns = {[](S& s) {
                                       s.initial_velocity.value = {0.1, 0};
                                     },
                                     [](S& s) {
                                       s.initial_velocity.value = {0, 0.1};
                                     },
                                     [](S& s) { s.initial_velocity.reference = true; }};
  knobs["torque_limit"].turns = {[](S& s) { s.torque_limit = 0.1; }};
  knobs["feedforward"].turns = {[](S& s) { s.feedforward = false; }};
  knobs["integrator"].turns = {[](S& s) { s.integrator = Integrator::exact; }};
  knobs["substeps"].turns = {[](S& s) { s.substeps = 2; }, [](S& s) { s.substeps = 3; }};
  const auto in_the_middle = [](S& s) {
    s.disturbance.assign(static_cast<std::size_t>(s.trajectory.size()), {0, 0});
    s.disturbance[50] = {1, 0};
  };
  knobs["disturbance"].turns = {[](S& s) {
                                  s.disturbance = {{0.5, 0}};
                                },
                                [](S& s) {
                                  s.disturbance = {{0, 0.1}};
                                },
                                in_the_middle};
  knobs["viscous_friction"].turns = {[](S& s) { s.viscous_friction = 0.01; }};
  knobs["coulomb_friction"].turns = {[](S& s) { s.coulomb_friction = 0.01; }};
  knobs["viscous_scrub"].turns = {[](S& s) { s.viscous_scrub = 0.05; }};
  knobs["coulomb_scrub"].turns = {[](S& s) { s.coulomb_scrub = 0.02; }};
  knobs["pose_noise"].turns = {[](S& s) {
                                 s.pose_noise = {0.01, 0};
                               },
                               [](S& s) {
                                 s.pose_noise = {0, 0.01};
                               }};
  knobs["delay"].turns = {[](S& s) { s.delay = 1; }, [](S& s) { s.delay = 2; }};
  knobs["divergence_distance"].turns = {[](S& s) { s.divergence_distance = 1; }};
  knobs["divergence_distance"].given = [](S& s) { s.initial_pose = {3.0, 0, 0}; };
  const auto reckon_with = [](double Robot<double>::*member) {
    return [=](S& s) {
      s.model = s.robot;
      (*s.model).*member *= 1.2;
    };
  };
  knobs["model"].turns = {reckon_with(&Robot<double>::mass), reckon_with(&Robot<double>::inertia),
                          reckon_with(&Robot<double>::track_width),
                          reckon_with(&Robot<double>::wheel_radius)};
  const auto drive_with = [](double Motor<double>::*member, double value) {
    return [=](S& s) {
      s.motor = Motor<double>{};
      s.motor->supply_voltage = 3;
      (*s.motor).*member = value;
    };
  };
  using M = Motor<double>;
  knobs["motor"].turns = {drive_with(&M::resistance, 4),
                          drive_with(&M::torque_constant, 0.02),
                          drive_with(&M::back_emf_constant, 0.015),
                          drive_with(&M::gear_ratio, 20),
                          drive_with(&M::rotor_inertia, 1e-4),
                          drive_with(&M::viscous_friction, 0.05),
                          drive_with(&M::coulomb_friction, 0.05),
                          drive_with(&M::supply_voltage, 2),
                          drive_with(&M::dead_band, 0.5)};
  knobs["encoder_counts"].turns = {[](S& s) { s.encoder_counts = 50; },
                                   [](S& s) { s.encoder_counts = 100; }};
  knobs["odometry_errors"].turns = {[](S& s) {
                                      s.odometry_errors = {0.01, 0, 0};
                                    },
                                    [](S& s) {
                                      s.odometry_errors = {0, 0.01, 0};
                                    },
                                    [](S& s) {
                                      s.odometry_errors = {0, 0, 0.01};
                                    }};
  knobs["odometry_errors"].given = [](S& s) { s.encoder_counts = 100; };
  knobs["feedforward_limit"].turns = {[](S& s) { s.feedforward_limit = 1e-3; },
                                      [](S& s) { s.feedforward_limit = 2e-3; }};
  knobs["friction_feedforward"].turns = {[](S& s) {
                                           s.friction_feedforward = {0.01, 0};
                                         },
                                         [](S& s) {
                                           s.friction_feedforward = {0, 0.05};
                                         }};
  knobs["friction_feedforward_speed"].turns = {[](S& s) { s.friction_feedforward_speed = 2; }};
  knobs["friction_feedforward_speed"].given = [](S& s) { s.friction_feedforward = {0, 0.05}; };
  knobs["cost_weights"].turns = {[](S& s) {
                                   s.cost_weights = {2, 1, 1};
                                 },
                                 [](S& s) {
                                   s.cost_weights = {1, 2, 1};
                                 },
                                 [](S& s) {
                                   s.cost_weights = {1, 1, 2};
                                 }};
  knobs["seed"].turns = {[](S& s) { s.seed = 1; }, [](S& s) { s.seed = 2; }};
  knobs["seed"].given = [](S& s) { s.pose_noise = {0.01, 0.01}; };
  knobs["noise_source"].turns = {[](S& s) { s.noise_source = NoiseSource::counter; }};
  knobs["noise_source"].given = knobs["seed"].given;
  return knobs;
}

TEST(Knobs, EveryScenarioFieldChangesTheCost) {
  DistinctCosts costs;
  const auto cost = [](const Scenario& scenario) {
    return simulate(scenario, steady_settings(Form::positional)).metrics.cost;
  };
  Scenario start = short_scenario();
  // The ranunculoid starts at a cusp; an eight starts in motion.
  TrajectorySettings eight = start.trajectory.settings;
  eight.name = Curve::eight;
  start.trajectory = make(eight);
  start.initial_pose = {0.1, 0.1, 0.3};
  turn_every_knob(start, scenario_knobs(),
                  [&](const std::string& field, const Scenario& base, const Scenario& turned) {
                    costs.add(field, cost(base), cost(turned));
                  });
}

}  // namespace
}  // namespace nfopidn::test
