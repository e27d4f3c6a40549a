// Controller.
#include "bindings.hpp"
#include "nfopidn/analysis/conversion.hpp"
#include "nfopidn/tuning/structures.hpp"
#include "stepping.hpp"

namespace nfopidn::python {

namespace {

using Settings = ControllerSettings<double>;

PyController read_py_controller(const Json& document) {
  ControllerDesign design;
  check("Controller", read_controller(document, design));
  return PyController(design);
}

// A controller file of version 1 has no sample time. Said once a process: old files come in heaps.
void warn_of_old_file(const std::string& path) {
  static bool said = false;
  if (said) return;
  said = true;
  const std::string text =
      path + ": a controller file of version 1 does not carry its sample time; the controller is " +
      "run at that of any scenario. Controller.replace(sample_time=...).save() writes it";
  if (PyErr_WarnEx(PyExc_UserWarning, printable(text).c_str(), 1) != 0) {
    throw py::error_already_set();
  }
}

PyController load_py_controller(const std::string& path) {
  ControllerDesign design;
  bool is_old = false;
  const auto reader = [&is_old](const Json& document, ControllerDesign& result) {
    const Outcome outcome = read_controller(document, result);
    is_old = outcome && document["version"] == 1;
    return outcome;
  };
  check("Controller.load", load_document(path, reader, design));
  if (is_old) warn_of_old_file(path);
  return PyController(design);
}

ControllerDesign changed(const std::string& callable, ControllerDesign design,
                         const py::dict& arguments) {
  Settings& settings = design;
  Json given = to_json(arguments);
  // Python's infinity, but no whole number that only overflows.
  if (arguments.contains("memory") && py::isinstance<py::float_>(arguments["memory"]) &&
      given["memory"] == std::numeric_limits<double>::infinity()) {
    given["memory"] = "inf";
  }
  check(callable, read_settings(given, "", settings));
  check(callable, explain_consistency(design));
  if (!design.taps.empty()) {
    for (const char* name : {"gains", "alpha", "sigma", "generator", "memory"}) {
      if (!arguments.contains(name)) continue;
      raise(callable, {Status::inconsistent,
                       std::string(name) + " does not apply to a controller of free taps"});
    }
  }
  return design;
}

// Free taps have neither gains nor orders.
py::object unless_free(const PyController& self, const char* name) {
  if (!self.settings.taps.empty()) return py::none();
  return field_value<Settings>(self.settings, name);
}

// The names of settings, but for those given otherwise.
std::vector<std::string> settings_but(const std::vector<std::string>& taken) {
  std::vector<std::string> names;
  for (const std::string& name : field_names<Settings>()) {
    if (std::find(taken.begin(), taken.end(), name) == taken.end()) names.push_back(name);
  }
  return names;
}

PyController make_controller(const py::args& positional, const py::kwargs& keywords) {
  const py::dict arguments =
      bind_arguments("Controller", field_names<Settings>(), positional, keywords);
  for (const char* name : {"gains", "alpha", "sigma"}) {
    if (!arguments.contains(name)) {
      throw py::type_error(std::string("Controller() needs the argument '") + name + "'");
    }
  }
  return PyController(changed("Controller", Settings{}, arguments));
}

// The 11-vector of the paper, the 15-vector with an order pair a channel, or free taps.
py::array to_vector(const PyController& self) {
  const std::vector<double> x = parameters_of(parameter_set_of(self.settings), self.settings);
  return py::array_t<double>(static_cast<py::ssize_t>(x.size()), x.data());
}

PyController from_vector(const py::object& given, const py::kwargs& structure) {
  const Numbers x = real_numbers("Controller.from_vector", "x", given);
  if (x.ndim() != 1) {
    throw py::value_error("Controller.from_vector: x has " + std::to_string(x.ndim()) +
                          " dimensions; must have 1");
  }
  if (x.size() != 11 && x.size() != 15) {
    throw py::value_error("Controller.from_vector: x has " + std::to_string(x.size()) +
                          " numbers; must have 11, or 15 with an order pair for each channel");
  }
  const std::string callable = "Controller.from_vector";
  Json object = Json::object();
  Json gains = Json::array();
  for (int row = 0; row < 3; ++row) {
    gains.push_back({x.at(3 * row), x.at(3 * row + 1), x.at(3 * row + 2)});
  }
  object["gains"] = gains;
  if (x.size() == 11) {
    object["alpha"] = x.at(9);
    object["sigma"] = x.at(10);
  } else {
    object["alpha"] = {x.at(9), x.at(11), x.at(13)};
    object["sigma"] = {x.at(10), x.at(12), x.at(14)};
  }
  Settings settings;
  check(callable, read_settings(object, "", settings));
  return PyController(changed(
      callable, settings,
      bind_arguments(callable, settings_but({"gains", "alpha", "sigma"}), py::args(), structure)));
}

PyController from_continuous(const py::object& gains, const py::object& alpha,
                             const py::object& sigma, double dt, const py::object& prewarp,
                             const py::kwargs& structure) {
  const std::string callable = "Controller.from_continuous";
  py::dict arguments = bind_arguments(
      callable, settings_but({"gains", "alpha", "sigma", "sample_time"}), py::args(), structure);
  arguments["gains"] = gains;
  arguments["alpha"] = alpha;
  arguments["sigma"] = sigma;
  ControllerDesign design = changed(callable, Settings{}, arguments);
  if (const Range positive = greater_than(0); !std::isfinite(dt) || !positive.contains(dt)) {
    raise(callable, refuse_number("dt", dt, positive, "s"));
  }
  double warp = 0;
  try {
    if (!prewarp.is_none()) warp = prewarp.cast<double>();
  } catch (const py::cast_error&) {
    raise(callable, refuse(Status::not_a_choice, "prewarp", py::repr(prewarp).cast<std::string>(),
                           "a number [rad/s] or None"));
  }
  const Range below = {0, std::acos(-1.0) / dt, false, true};
  if (design.generator == Generator::tustin && !below.contains(warp)) {
    raise(callable, refuse_number("prewarp", warp, below, "rad/s, Nyquist's frequency"));
  }
  for (int channel = 0; channel < channel_count; ++channel) {
    const auto factors =
        gain_factors(design.generator, design.alpha[channel], design.sigma[channel], dt, warp);
    for (std::size_t i = 0; i < 3; ++i) design.gains[channel][i] *= factors[i];
  }
  design.sample_time = dt;
  // What dt makes of the gains may be beyond what a controller has.
  py::list made;
  for (const auto& row : design.gains) {
    made.append(py::cast(std::vector<double>(std::begin(row), std::end(row))));
  }
  py::dict gains_made;
  gains_made["gains"] = made;
  return PyController(changed(callable, design, gains_made));
}

PyController from_taps(const py::object& taps, const py::kwargs& structure) {
  const std::string callable = "Controller.from_taps";
  Json document = {{"format", controller_format}, {"version", controller_version}};
  document.update(to_json(
      bind_arguments(callable, settings_but({"gains", "alpha", "sigma", "generator", "memory"}),
                     py::args(), structure)));
  document["taps"] = to_json(taps);
  ControllerDesign design;
  check(callable, read_controller(document, design));
  return PyController(design);
}

// Settings changed, and the robot.
PyController replaced(const PyController& self, const py::kwargs& changes) {
  const std::string callable = "Controller.replace";
  std::vector<std::string> names = settings_but({});
  names.emplace_back("robot");
  const py::dict arguments = bind_arguments(callable, names, py::args(), changes);
  ControllerDesign design = self.settings;
  if (arguments.contains("robot")) {
    const py::object robot = arguments.attr("pop")("robot");
    if (!robot.is_none() && !py::isinstance<Robot<double>>(robot)) {
      throw py::type_error(callable + ": robot must be a Robot or None");
    }
    design.robot.reset();
    if (!robot.is_none()) design.robot = robot.cast<const Robot<double>&>();
  }
  return PyController(changed(callable, design, arguments));
}

// A positive number of TrackingScale.
double scale_number(const char* name, double value, const char* unit) {
  const Range range = {1e-6, 1e6, false, false};
  if (!std::isfinite(value) || !range.contains(value)) {
    raise("Controller.recommended", refuse_number(name, value, range, unit));
  }
  return value;
}

PyController recommended(const Robot<double>& robot, double sample_time, double torque_limit,
                         double peak_speed) {
  const TrackingScale scale = {robot, scale_number("sample_time", sample_time, "s"),
                               scale_number("torque_limit", torque_limit, "N m"),
                               scale_number("peak_speed", peak_speed, "m/s")};
  // A robot far from any other may have gains beyond what a controller has.
  return read_py_controller(write_controller(recommended_tracking(scale)));
}

py::array taps(const PyController& self) {
  const StandardArithmetic arithmetic;
  if (self.settings.memory.is_infinite()) {
    raise("Controller.taps", {Status::out_of_range, "memory is inf; has no end of taps"});
  }
  const std::vector<double> all = parameters_of(ParameterSet::taps, self.settings);
  py::array_t<double> table({3, self.settings.memory + 2});
  std::copy(all.begin(), all.end(), table.mutable_data());
  return read_only(std::move(table));
}

py::dict parameters_of_law(const PyController& self) {
  py::dict result;
  if (!self.settings.needs_tracking_law()) return result;
  const LawParameters<double> law = law_parameters<double>(self.settings);
  const char* const* name = LawParameters<double>::names;
  LawParameters<double>::each(law, [&](double number) { result[*name++] = number; });
  return result;
}

py::tuple step_controller(PyController& self, const py::object& measurement,
                          const py::object& reference, const py::object& torque_limit) {
  const std::string callable = "Controller.step";
  const auto [measured, wanted] = step_arguments(callable, measurement, reference);
  const bool started = self.running.is_started();
  const double limit =
      step_limit(callable, torque_limit,
                 started ? self.running.torque_limit() : ControlLimits<double>{}.torque);
  if (self.settings.lateral == Lateral::speed && self.settings.speed_scale == 0 && !started) {
    raise(callable, refuse_number("speed_scale", 0, greater_than(0), "m/s, outside a simulation"));
  }
  if (self.settings.net == Net::speed_errors && !self.settings.sample_time.has_value() &&
      !started) {
    raise(callable, refuse(Status::inconsistent, "sample_time", "unknown",
                           "given, in seconds, with net \"speed-errors\""));
  }
  const TorquePair<double> torque = self.running.step(self.settings, limit, measured, wanted);
  return py::make_tuple(torque.left, torque.right);
}

void start_controller(PyController& self, const Scenario& scenario) {
  check("Controller.start", explain_sample_time(self.settings, scenario.trajectory.dt()));
  warn_of_robot("Controller.start", self.settings, scenario.modelled_robot());
  self.running.start(self.settings, limits_of(scenario), scenario.initial_velocity.reference);
}

}  // namespace

void bind_controller(py::module_& module) {
  module.attr("LEAST_SPEED_SCALE") = least_speed_scale;
  module.def(
      "check_sample_time",
      [](const PyController& controller, double dt) {
        const Outcome outcome = explain_sample_time(controller.settings, dt);
        if (!outcome) throw py::value_error(outcome.message);
      },
      py::arg("controller"), py::arg("dt"));
  using C = PyController;
  const std::string rest = [] {
    Json defaults = write_settings(Settings{});
    std::string text;
    for (const auto& item : defaults.items()) {
      const bool required = item.key() == "gains" || item.key() == "alpha" || item.key() == "sigma";
      text +=
          (text.empty() ? "" : ", ") + item.key() + (required ? "" : "=" + literal(item.value()));
    }
    return text;
  }();
  const std::string doc =
      "Controller(" + rest +
      ")\n--\n\nThe NFOPIDN controller: settings, and the law itself in step(). A setting out of "
      "range\nraises ValueError. Copies, pickles and replace() have the settings and are at rest; "
      "copy(state=True)\nkeeps the past errors.\n\nParameters\n----------\n" +
      parameters_text<Settings>(field_names<Settings>());
  py::class_<C> cls(module, "Controller", py::is_final(), doc.c_str());
  cls.def(py::init(&make_controller));
  cls.def_static(
      "published",
      [](const py::args& positional, const py::kwargs& changes) {
        const std::string callable = "Controller.published";
        std::vector<std::string> names = settings_but({"memory"});
        names.insert(names.begin(), "memory");
        if (positional.size() > 1) {
          throw py::type_error(callable + "() takes at most 1 positional argument, got " +
                               std::to_string(positional.size()));
        }
        const py::dict arguments = bind_arguments(callable, names, positional, changes);
        return C(changed(callable, Settings{}, arguments));
      },
      "published(memory=5, **changes)\n--\n\nThe paper's gains and orders (its Table 3), with "
      "changes.");
  cls.def_static(
      "tuned_nominal", [] { return C(tuned_nominal()); },
      "tuned_nominal()\n--\n\nThe best incremental, decoupled controller of the published "
      "scenario, "
      "E = 0.01722, found by\nnfopidn_sim --tune --structure incremental --tune-seed 1 --maxfev "
      "40000.");
  const TrackingScale eddie;
  cls.def_static(
      "recommended", &recommended, py::arg("robot") = eddie.robot,
      py::arg("sample_time") = eddie.sample_time, py::arg("torque_limit") = eddie.torque_limit,
      py::arg("peak_speed") = eddie.peak_speed,
      "recommended(robot=Robot(), sample_time=0.2, torque_limit=3.078, "
      "peak_speed=0.3350698998007755)\n--\n\nThe tracking law with gains for a family of robots, "
      "paths and delays, scaled to a robot (Eddie), a\nsample time [s], a torque limit of each "
      "wheel [N m] and the path's peak speed [m/s].\n\nA covariance matrix adaptation found them "
      "for the paper's robot over the 132 scenarios of\nnfopidn.families.benchmark(\"J++\"), "
      "outside "
      "this repository; its own search, python bench/families.py\n--families J++ --save gains, "
      "ends beside them, at the same mean cost, 0.0393. The rules of scaling\nare in "
      "docs/theory.md: the loop keeps its pace in seconds. tune(structure=\"tracking\") finds "
      "gains\nfor one robot, which may be faster. The robot stands in the controller's file."
      "\n\nValueError: a number out of range, or a gain beyond what a controller has.");
  cls.def_static("from_vector", &from_vector, py::arg("x"),
                 "from_vector(x, **structure)\n--\n\nFrom (kp_x, ki_x, kd_x, kp_y, ki_y, kd_y, "
                 "kp_theta, ki_theta, kd_theta, alpha, sigma), or 15\nnumbers that end alpha_x, "
                 "sigma_x, alpha_y, sigma_y, alpha_theta, sigma_theta.");
  cls.def("to_vector", &to_vector, Computes(),
          "to_vector(self)\n--\n\nThe inverse of from_vector; of free taps, all of them.");
  cls.def_static(
      "from_continuous", &from_continuous, Computes(), py::arg("gains"), py::arg("alpha"),
      py::arg("sigma"), py::arg("dt"), py::arg("prewarp") = paper_prewarp,
      "from_continuous(gains, alpha, sigma, dt, prewarp=15.0, **structure)\n--\n\nFrom the "
      "continuous gains Kp, Ki, Kd of eq. 25, (3, 3), for the sample time dt [s], which\nis the "
      "controller's sample_time then. prewarp is\nw_c "
      "[rad/s], None: 0; with generator \"gl\" it is not used.");
  cls.def_static(
      "from_taps", &from_taps, py::arg("taps"),
      "from_taps(taps, **structure)\n--\n\nFrom the channels' filters themselves, "
      "(3, memory + 2), newest error first, in the\nplace of gains and orders, which are "
      "None then.");
  cls.def(
      "to_json", [](const C& self) { return write_controller(self.settings).dump(); },
      "to_json(self)\n--\n\nThe text that save() writes, on one line.");
  cls.def_static(
      "from_json",
      [](const std::string& text) {
        Json document;
        check("Controller.from_json", parse_json(text, document));
        return read_py_controller(document);
      },
      py::arg("text"), "from_json(text)\n--\n\nThe inverse of to_json.");
  cls.def_static(
      "load", [](const py::object& path) { return load_py_controller(file_name(path)); },
      py::arg("path"),
      "load(path)\n--\n\nReads a controller file (JSON). A file of version 1 does not carry its "
      "sample time, which a\nUserWarning says once a process.");
  cls.def(
      "save",
      [](const C& self, const py::object& path) {
        check("Controller.save",
              write_file(file_name(path), document_text(write_controller(self.settings))));
      },
      py::arg("path"), "save(self, path)\n--\n\nWrites a controller file (JSON).");
  cls.def("replace", &replaced,
          "replace(self, **changes)\n--\n\nA copy with some settings changed, at rest; robot: the "
          "Robot that the gains are made for, or\nNone, not known.");
  cls.def_property_readonly(
      "robot",
      [](const C& self) -> py::object {
        return self.settings.robot ? py::cast(*self.settings.robot) : py::none();
      },
      "the Robot that the gains are made for, or None: not known. simulate() warns of a scenario's "
      "that is\noff by over 20 % in mass, inertia, track or wheel radius.");
  add_fields<Settings>(cls, [](const C& self) -> const Settings& { return self.settings; });
  for (const char* name : {"gains", "alpha", "sigma"}) {
    const py::object documented = cls.attr(name).attr("__doc__");
    cls.def_property_readonly(
        name, [name](const C& self) { return unless_free(self, name); },
        documented.cast<std::string>().c_str());
  }
  const std::string memory_text = cls.attr("memory").attr("__doc__").cast<std::string>();
  cls.def_property_readonly(
      "memory",
      [](const C& self) -> py::object {
        if (self.settings.memory.is_infinite()) return py::module_::import("math").attr("inf");
        return py::int_(self.settings.memory.samples);
      },
      memory_text.c_str());
  cls.def_property_readonly(
      "uses_tracking_law", [](const C& self) { return self.settings.needs_tracking_law(); },
      "Whether it has parts that eqs. 30-36 do not have (docs/theory.md).");
  cls.def_property_readonly("law_parameters", &parameters_of_law,
                            "dict: what the tracking law has besides its taps, as its step reads "
                            "it (docs/theory.md); empty\nwithout its parts");
  cls.def_property_readonly("taps", &taps,
                            "(3, memory + 2): the channels' fused filters, newest error first");
  cls.def("step", &step_controller, Computes(), py::arg("measurement"), py::arg("reference"),
          py::arg("torque_limit") = py::none(),
          "step(self, measurement, reference, torque_limit=None)\n--\n\nThe limited torques (left, "
          "right) [N m] of one sample.\n\nmeasurement: x, y [m], theta [rad] and, not used, v, "
          "omega. reference: a row of\nScenario.reference. torque_limit [N m]: None is that of the "
          "scenario that start() was given, or 3.078 of\nthe paper's robot. ValueError for what is "
          "not finite; the memory is then as before.");
  cls.def("start", &start_controller, Computes(), py::arg("scenario"),
          "start(self, scenario)\n--\n\nMakes ready for a run of the scenario as simulate() does "
          "it: at rest, with the scenario's torque limit,\nsample time and peak speed, which "
          "step() then need not be told. ValueError: the controller is\nmade for another sample "
          "time.");
  cls.def(
      "reset", [](C& self) { self.running.reset(); },
      "reset(self)\n--\n\nForgets past errors and torque.");
  cls.def(
      "feedback",
      [](const C& self) {
        const TorquePair<double> torque = self.running.feedback();
        return py::make_tuple(torque.left, torque.right);
      },
      "feedback(self)\n--\n\nThe unlimited feedback part of the last step's torques [N m].");
  cls.def(
      "copy",
      [](const C& self, bool state) {
        C copy(self.settings);
        if (state) copy.running = self.running.copy();
        return copy;
      },
      py::arg("state") = false,
      "copy(self, state=False)\n--\n\nA copy at rest, as copy.copy(), replace() and pickle make "
      "it; "
      "with `state` one that goes on\nfrom the same past errors and torque.");
  cls.def("__repr__", [](const C& self) {
    const std::string changes = arguments_text<Settings>(self.settings, false);
    std::string robot;
    if (self.settings.robot) {
      robot =
          ".replace(robot=" + py::repr(py::cast(*self.settings.robot)).cast<std::string>() + ")";
    }
    if (self.settings.taps.empty()) return "Controller.published(" + changes + ")" + robot;
    return "Controller.from_taps(<3 x " + std::to_string(self.settings.memory + 2) + ">" +
           (changes.empty() ? "" : ", " + changes) + ")" + robot;
  });
  add_value_semantics<C>(
      cls, [](const C& self) { return write_controller(self.settings); }, read_py_controller);
}

}  // namespace nfopidn::python
