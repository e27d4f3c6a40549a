// simulate() and SimulationResult.
#include <variant>

#include "nfopidn/io/json_rival.hpp"
#include "nfopidn/simulation/playback.hpp"
#include "nfopidn/simulation/recorded.hpp"
#include "nfopidn/simulation/run_figures.hpp"
#include "nfopidn/tuning/monte_carlo.hpp"
#include "stepping.hpp"

namespace nfopidn::python {

void warn_of_robot(const ControllerDesign& design, const Robot<double>& robot) {
  const std::string text = explain_robot(design, robot);
  if (!text.empty() && PyErr_WarnEx(PyExc_UserWarning, ("simulate: " + text).c_str(), 1) != 0) {
    throw py::error_already_set();
  }
}

namespace {

// Of a run under given torques there is none.
using Driver = std::variant<ControllerDesign, rivals::RivalDesign, std::monostate>;

struct PyResult {
  Scenario scenario;
  Driver driver;
  SimulationResult result;
};

PyResult run(const Scenario* scenario, const py::object& controller) {
  PyResult run{scenario != nullptr ? *scenario : Scenario::published(), ControllerDesign{}, {}};
  if (py::isinstance<PyRival>(controller)) {
    run.driver = controller.cast<const PyRival&>().design;
  } else if (py::isinstance<PyController>(controller)) {
    const ControllerDesign& design = controller.cast<const PyController&>().settings;
    check("simulate", explain_sample_time(design, run.scenario.trajectory.dt()));
    warn_of_robot("simulate", design, run.scenario.modelled_robot());
    run.driver = design;
  } else if (!controller.is_none()) {
    throw py::type_error("simulate: controller must be a Controller or a Rival, not " +
                         py::str(py::type::of(controller)).cast<std::string>());
  }
  const auto* rival = std::get_if<rivals::RivalDesign>(&run.driver);
  watched([&] {
    run.result = rival != nullptr
                     ? simulate(run.scenario, *rival)
                     : simulate_as_drawn(run.scenario, std::get<ControllerDesign>(run.driver));
  });
  return run;
}

PyResult run_torques(const Scenario& scenario, const py::object& given) {
  const Numbers torque = real_numbers("play", "torque", given);
  const py::ssize_t samples = scenario.trajectory.size();
  if (torque.ndim() != 2 || torque.shape(0) != samples || torque.shape(1) != 2) {
    throw py::value_error("torque must have the shape (" + std::to_string(samples) + ", 2)");
  }
  const Range range = between(-scenario.torque_limit, scenario.torque_limit);
  std::vector<TorquePair<double>> pairs;
  for (py::ssize_t k = 0; k < samples; ++k) {
    for (py::ssize_t wheel = 0; wheel < 2; ++wheel) {
      if (range.contains(torque.at(k, wheel))) continue;
      raise("play",
            refuse_number("torque[" + std::to_string(k) + "]", torque.at(k, wheel), range, "N m"));
    }
    pairs.push_back({torque.at(k, 0), torque.at(k, 1)});
  }
  PyResult run{scenario, std::monostate(), {}};
  watched([&] { run.result = play(run.scenario, pairs); });
  return run;
}

double finite_at(const Numbers& numbers, const char* name, py::ssize_t row, py::ssize_t column) {
  const double number = numbers.at(row, column);
  if (!std::isfinite(number)) {
    raise("score",
          refuse_number(std::string(name) + "[" + std::to_string(row) + "]", number, any_number()));
  }
  return number;
}

// A run that took place elsewhere: rows of x, y, theta, v, omega and of torques left, right, and of
// the feedback's part of those.
PyResult score_rows(const Scenario& scenario, const py::object& controller,
                    const py::object& states, const py::object& torques,
                    const py::object& feedbacks) {
  const Numbers state = real_numbers("score", "state", states);
  const Numbers torque = real_numbers("score", "torque", torques);
  const Numbers feedback = real_numbers("score", "feedback", feedbacks);
  const py::ssize_t rows = state.shape(0);
  std::vector<RecordedSample> samples;
  for (py::ssize_t k = 0; k < rows; ++k) {
    const auto pair = [&](const Numbers& numbers, const char* name) {
      return TorquePair<double>{finite_at(numbers, name, k, 0), finite_at(numbers, name, k, 1)};
    };
    const auto number = [&](py::ssize_t i) { return finite_at(state, "state", k, i); };
    samples.push_back({{number(0), number(1), number(2), number(3), number(4)},
                       pair(torque, "torque"),
                       pair(feedback, "feedback")});
  }
  PyResult run{scenario, std::monostate(), {}};
  if (py::isinstance<PyRival>(controller)) {
    run.driver = controller.cast<const PyRival&>().design;
  } else if (!controller.is_none()) {
    run.driver = controller.cast<const PyController&>().settings;
  }
  watched([&] { run.result = score(run.scenario, samples); });
  return run;
}

// (N, 3): what simulate() adds to the measured x, y [m] and theta [rad] at each sample.
py::array noise_rows(const Scenario& scenario) {
  const PreparedRun run = prepare(scenario);
  const auto samples = static_cast<py::ssize_t>(run.reference.size());
  py::array_t<double> rows({samples, py::ssize_t{3}});
  auto cell = rows.mutable_unchecked<2>();
  for (py::ssize_t k = 0; k < samples; ++k) {
    const Measurement<double> noise = run.noise.empty() ? Measurement<double>{0, 0, 0, 0, 0}
                                                        : run.noise[static_cast<std::size_t>(k)];
    cell(k, 0) = noise.x;
    cell(k, 1) = noise.y;
    cell(k, 2) = noise.theta;
  }
  return read_only(std::move(rows));
}

Json write_driver(const Driver& driver) {
  if (const auto* rival = std::get_if<rivals::RivalDesign>(&driver)) return write_rival(*rival);
  if (std::holds_alternative<std::monostate>(driver)) return nullptr;
  return write_controller(std::get<ControllerDesign>(driver));
}

Driver read_driver(const Json& document) {
  if (document.is_null()) return std::monostate();
  if (document.value("format", "") == rival_format) {
    rivals::RivalDesign design;
    check("pickle", read_rival(document, design));
    return design;
  }
  ControllerDesign design;
  check("pickle", read_controller(document, design));
  return design;
}

py::object driver_of(const PyResult& self) {
  if (const auto* rival = std::get_if<rivals::RivalDesign>(&self.driver))
    return py::cast(PyRival(*rival));
  if (std::holds_alternative<std::monostate>(self.driver)) return py::none();
  return py::cast(PyController(std::get<ControllerDesign>(self.driver)));
}

py::array block(const py::object& self, int first, int count) {
  const RunTable& table = self.cast<const PyResult&>().result.table;
  return view(table.data() + first, {table.rows(), count}, {column_count, 1}, self);
}

py::array column(const py::object& self, int index) {
  const RunTable& table = self.cast<const PyResult&>().result.table;
  return view(table.data() + index, {table.rows()}, {column_count}, self);
}

py::dict columns(const py::object& self) {
  py::dict result;
  for (int i = 0; i < column_count; ++i) result[column_names[i]] = column(self, i);
  return result;
}

py::dict metrics(const PyResult& self) {
  py::dict result;
  Metrics::fields(
      [&](const auto& field) { result[field.name] = self.result.metrics.*field.member; });
  return result;
}

std::string repr_of_result(const PyResult& self) {
  std::string text = "SimulationResult(cost=" + number_text(self.result.metrics.cost) + ", " +
                     std::to_string(self.result.table.rows()) + " samples";
  if (self.result.diverged) text += ", diverged_at=" + number_text(self.result.diverged_at);
  return text + ")";
}

py::tuple get_state(const PyResult& self) {
  const RunTable& table = self.result.table;
  const py::bytes rows(reinterpret_cast<const char*>(table.data()),
                       static_cast<std::size_t>(table.size()) * sizeof(double));
  return py::make_tuple(write_scenario(self.scenario).dump(), write_driver(self.driver).dump(),
                        rows, self.result.metrics.cost, self.result.diverged,
                        self.result.diverged_at);
}

PyResult set_state(const py::tuple& state) {
  PyResult self;
  Json document;
  check("pickle", parse_json(state[0].cast<std::string>(), document));
  check("pickle", read_scenario(document, self.scenario));
  check("pickle", parse_json(state[1].cast<std::string>(), document));
  self.driver = read_driver(document);
  const auto rows = state[2].cast<std::string>();
  const std::size_t row_size = column_count * sizeof(double);
  self.result.table.resize(static_cast<Eigen::Index>(rows.size() / row_size), column_count);
  std::memcpy(self.result.table.data(), rows.data(),
              static_cast<std::size_t>(self.result.table.size()) * sizeof(double));
  self.result.metrics = measure(self.result.table, state[3].cast<double>(), self.scenario);
  self.result.diverged = state[4].cast<bool>();
  self.result.diverged_at = state[5].cast<double>();
  return self;
}

}  // namespace

void bind_simulation(py::module_& module) {
  using R = PyResult;
  py::class_<R> cls(module, "SimulationResult", py::is_final(),
                    "A simulated run. Arrays are read-only views of N rows, one a sample, up to "
                    "where the run\ndiverged.");
  cls.def_property_readonly(
      "cost", [](const R& self) { return self.result.metrics.cost; }, "E of eq. 41");
  cls.def_property_readonly("metrics", &metrics, "dict of figures; docs/theory.md defines them");
  cls.def_property_readonly("columns", &columns, "dict of the run table's columns, (N,) each");
  cls.def_property_readonly(
      "pose", [](const py::object& self) { return block(self, column_x, 3); },
      "(N, 3): x, y [m], theta [rad]");
  cls.def_property_readonly(
      "torque", [](const py::object& self) { return block(self, column_tau_left, 2); },
      "(N, 2): total torques left, right [N m]");
  cls.def_property_readonly(
      "t", [](const py::object& self) { return column(self, column_t); }, "(N,): times [s]");
  cls.def_property_readonly(
      "diverged_at",
      [](const R& self) -> py::object {
        if (!self.result.diverged) return py::none();
        return py::float_(self.result.diverged_at);
      },
      "time [s] at which the run diverged, or None");
  cls.def_readonly("scenario", &R::scenario, "the Scenario");
  cls.def_property_readonly(
      "controller", &driver_of,
      "the Controller, at rest, or the Rival; None of a run under given torques");
  cls.def(
      "to_csv",
      [](const R& self, const py::object& path) {
        check("SimulationResult.to_csv",
              write_file(file_name(path), run_table_csv(self.result.table)));
      },
      py::arg("path"), "to_csv(self, path)\n--\n\nWrites the run table.");
  cls.def("__len__", [](const R& self) { return self.result.table.rows(); });
  cls.def("__repr__", &repr_of_result);
  cls.def(py::pickle(&get_state, &set_state));
  cls.def("__copy__", [](const R& self) { return self; });
  cls.def("__deepcopy__", [](const R& self, const py::dict&) { return self; });

  module.def(
      "settling_time", [](const R& run) { return settling_time(run.result); }, py::arg("run"));
  module.def(
      "torque_deviation", [](const R& run) { return torque_deviation(run.result); },
      py::arg("run"));
  module.def("play", &run_torques, py::arg("scenario"), py::arg("torque"));
  module.def("score_rows", &score_rows, py::arg("scenario"), py::arg("controller"),
             py::arg("state"), py::arg("torque"), py::arg("feedback"));
  module.def("noise_rows", &noise_rows, Computes(), py::arg("scenario"));
  module.def("metric_fields", [] {
    py::dict result;
    Metrics::fields([&](const auto& f) { result[f.name] = py::make_tuple(f.unit, f.text); });
    return result;
  });
  module.def("simulate", &run, py::arg("scenario") = py::none(), py::arg("controller") = py::none(),
             "simulate(scenario=None, controller=None)\n--\n\nRuns a scenario under a controller, "
             "by default the published ones, and returns a\nSimulationResult. A run that diverges "
             "keeps its rows so far and says when in diverged_at.\nCtrl-C ends a "
             "long one.");
}

}  // namespace nfopidn::python
