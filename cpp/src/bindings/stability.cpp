// What nfopidn.stability is made of. Python has checked and named the arguments of basin() and
// linear_plant(); python/nfopidn/stability/ has the callers.
#include <pybind11/eigen.h>

#include "bindings.hpp"
#include "nfopidn/analysis/basin.hpp"
#include "nfopidn/analysis/floquet.hpp"
#include "nfopidn/analysis/linear_plant.hpp"

namespace nfopidn::python {

namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;

template <class Choice>
std::string word(Choice choice) {
  return ChoiceNames<Choice>::names[static_cast<int>(choice)];
}

py::object distance(const SwitchDistance& nearest) {
  return py::make_tuple(nearest.distance, nearest.sample);
}

RowMatrix reference_rows(const PeriodicReference& reference) {
  RowMatrix rows(reference.period, 8);
  for (int k = 0; k < reference.period; ++k) {
    const ReferenceSample<double>& r = reference.samples[static_cast<std::size_t>(k)];
    rows.row(k) << r.x, r.y, r.theta, r.v, r.omega, r.tau_left, r.tau_right, r.reverse ? 1.0 : 0.0;
  }
  return rows;
}

py::dict analyse(const Scenario& scenario, const PyController& controller) {
  LoopStability found;
  Outcome outcome;
  watched([&] { outcome = analyse_loop(scenario, controller.settings, found); });
  check("stability.loop", outcome);
  py::dict result;
  result["verdict"] = word(found.verdict);
  result["period"] = found.reference.period;
  result["laps"] = found.reference.laps;
  result["past_errors"] = found.states.errors;
  result["reference"] = reference_rows(found.reference);
  result["orbit"] = RowMatrix(found.orbit.states.transpose());
  result["residual"] = found.orbit.residual;
  result["iterations"] = found.orbit.iterations;
  result["start"] = word(found.orbit.start);
  result["multipliers"] = Eigen::VectorXcd(found.multipliers);
  result["log_radius"] = found.log_radius;
  result["heading_wrap"] = distance(found.switches.heading_wrap);
  result["torque_left"] = distance(found.switches.torque_left);
  result["torque_right"] = distance(found.switches.torque_right);
  result["limited_samples"] = found.switches.limited_samples;
  return result;
}

// A period's reference, and the loop on it, which an analysis has shown to be possible.
struct Period {
  PeriodicReference reference;
  PreparedRun run;

  Period(const Scenario& scenario, const PyController& controller) : run(prepare(scenario)) {
    check("stability", check_loop(scenario, controller.settings));
    check("stability", find_period(scenario, controller.settings.frame == Frame::world, reference));
  }
};

py::array jacobians(const Scenario& scenario, const PyController& controller, const Rows& orbit) {
  const Period period(scenario, controller);
  StepMap<Dual<double>> map(period.run, controller.settings, period.reference);
  py::array_t<double> result({period.reference.period, map.size(), map.size()});
  Eigen::MatrixXd jacobian;
  for (int k = 0; k < period.reference.period; ++k) {
    step_jacobian(map, k, orbit.data(k), jacobian);
    Eigen::Map<RowMatrix>(result.mutable_data(k), map.size(), map.size()) = jacobian;
  }
  return result;
}

py::array final_errors(const Scenario& scenario, const PyController& controller, const Rows& poses,
                       int last_samples, int threads) {
  static_assert(sizeof(FinalErrors) == 2 * sizeof(double), "a row of the result");
  py::array_t<double> result({poses.shape(0), py::ssize_t{2}});
  auto* const errors = reinterpret_cast<FinalErrors*>(result.mutable_data());
  const double* const first = poses.data();
  const py::ssize_t count = poses.shape(0);
  watched([&] {
    basin(prepare(scenario), controller.settings, first, count, last_samples, threads, errors);
  });
  return result;
}

py::tuple linear_plant(const Scenario& scenario, double speed) {
  // The corner of Coulomb scrub lies where the robot goes straight: it is left out.
  Scenario smooth = scenario;
  smooth.coulomb_scrub = 0;
  const LinearPlant plant = linearise_plant(detail::robot_drive(smooth), speed);
  return py::make_tuple(RowMatrix(plant.state), RowMatrix(plant.torque));
}

}  // namespace

void bind_stability(py::module_& module) {
  module.def("analyse_loop", &analyse, Computes(), py::arg("scenario"), py::arg("controller"));
  module.def("loop_jacobians", &jacobians, Computes(), py::arg("scenario"), py::arg("controller"),
             py::arg("orbit"));
  module.def("final_errors", &final_errors, Computes(), py::arg("scenario"), py::arg("controller"),
             py::arg("poses"), py::arg("last_samples"), py::arg("threads"));
  module.def("linear_plant", &linear_plant, Computes(), py::arg("scenario"), py::arg("speed"));
}

}  // namespace nfopidn::python
