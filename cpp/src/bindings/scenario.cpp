// Robot, Trajectory and Scenario.
#include <random>

#include "bindings.hpp"

namespace nfopidn::python {

namespace {

// Plain settings with a class of their own, which Python calls by this name.
template <class Settings>
constexpr const char* settings_name = "Robot";
template <>
constexpr const char* settings_name<Motor<double>> = "Motor";

template <class Settings>
Settings read_own(const Json& object) {
  Settings settings;
  check(settings_name<Settings>, read_settings(object, "", settings));
  return settings;
}

Trajectory trajectory_from_json(const Json& object) {
  Trajectory trajectory;
  check("Trajectory", read_trajectory(object, "", trajectory));
  return trajectory;
}

Scenario scenario_from_json(const Json& document) {
  Scenario scenario = default_scenario();
  check("Scenario", read_scenario(document, scenario));
  return scenario;
}

std::vector<std::string> named_path_arguments(const std::string& name) {
  if (name == "ranunculoid") {
    return {"period", "dt", "cusps", "heading", "scale", "laps", "derivatives"};
  }
  return {"period", "dt", "heading", "scale", "laps", "derivatives"};
}

Trajectory named_path(const std::string& name, const py::args& positional,
                      const py::kwargs& keywords) {
  const std::string callable = "Trajectory." + name;
  Json object = to_json(bind_arguments(callable, named_path_arguments(name), positional, keywords));
  object["name"] = name;
  Trajectory trajectory;
  check(callable, read_trajectory(object, "", trajectory));
  return trajectory;
}

std::string named_path_doc(const std::string& name) {
  const Json defaults = write_settings(TrajectorySettings{});
  std::string signature;
  for (const std::string& argument : named_path_arguments(name)) {
    signature += (signature.empty() ? "" : ", ") + argument + "=" + literal(defaults[argument]);
  }
  return name + "(" + signature + ")\n--\n\nThe path `" + name +
         "` (docs/theory.md has its equation). ValueError names what is out of range.\n\n"
         "Parameters\n----------\n" +
         parameters_text<TrajectorySettings>(named_path_arguments(name));
}

Eigen::ArrayXd to_eigen(const py::object& object, const std::string& name) {
  const std::string callable = "Trajectory.from_samples";
  const Numbers samples = real_numbers(callable, name, object);
  if (samples.ndim() != 1) {
    throw py::value_error(callable + ": " + name + " has " + std::to_string(samples.ndim()) +
                          " dimensions; must have 1");
  }
  return Eigen::Map<const Eigen::ArrayXd>(samples.data(), samples.size());
}

// Flags of a path of samples, or none.
std::vector<unsigned char> to_flags(const py::object& object) {
  std::vector<unsigned char> flags;
  if (object.is_none()) return flags;
  const Eigen::ArrayXd numbers = to_eigen(object, "reverse");
  for (Eigen::Index k = 0; k < numbers.size(); ++k) {
    if (numbers(k) != 0 && numbers(k) != 1) {
      raise("Trajectory.from_samples",
            refuse(Status::not_a_choice, "reverse[" + std::to_string(k) + "]",
                   number_text(numbers(k)), "0 or 1"));
    }
    flags.push_back(numbers(k) != 0 ? 1 : 0);
  }
  return flags;
}

TrajectorySettings sample_settings(const std::string& callable, const py::dict& arguments) {
  TrajectorySettings settings;
  settings.name = Curve::samples;
  check(callable, read_settings(to_json(arguments), "", settings));
  return settings;
}

// Where the positions do not tell the heading, the caller is told.
void warn_of_standstill(const Trajectory& trajectory) {
  for (const std::string& note : trajectory.notes) {
    if (note.find("standstill_speed") == std::string::npos) continue;
    if (PyErr_WarnEx(PyExc_UserWarning, note.c_str(), 1) != 0) throw py::error_already_set();
  }
}

Trajectory from_samples(const py::object& x, const py::object& y, const py::object& dt,
                        const py::object& heading, const py::object& laps, const py::object& theta,
                        const py::object& reverse, bool closed, const py::object& standstill,
                        const py::object& origin) {
  const std::string callable = "Trajectory.from_samples";
  using py::literals::operator""_a;
  const TrajectorySettings settings =
      sample_settings(callable, py::dict("dt"_a = dt, "heading"_a = heading, "laps"_a = laps,
                                         "standstill_speed"_a = standstill));
  Samples samples{to_eigen(x, "x"), to_eigen(y, "y"), {}, to_flags(reverse), {0, 0}};
  const Eigen::ArrayXd offset = to_eigen(origin, "origin");
  for (Eigen::Index i = 0; i < offset.size(); ++i) {
    if (json::position_range.contains(offset(i))) continue;
    raise(callable,
          refuse_number("origin[" + std::to_string(i) + "]", offset(i), json::position_range, "m"));
  }
  if (offset.size() != 2) throw py::value_error(callable + ": origin must have 2 numbers");
  samples.origin = {offset(0), offset(1)};
  if (!theta.is_none()) samples.theta = to_eigen(theta, "theta");
  if (closed) close_path(samples);
  Trajectory trajectory;
  check(callable, build_trajectory(settings, samples, "", trajectory));
  warn_of_standstill(trajectory);
  return trajectory;
}

Trajectory from_csv(const py::object& path, const py::object& heading, const py::object& laps,
                    const py::object& dt, bool closed, const py::object& standstill) {
  const std::string callable = "Trajectory.from_csv";
  using py::literals::operator""_a;
  py::dict given("laps"_a = laps, "standstill_speed"_a = standstill);
  if (!heading.is_none()) given["heading"] = heading;
  if (!dt.is_none()) given["dt"] = dt;
  TableReading reading;
  reading.settings = sample_settings(callable, given);
  reading.dt = dt.is_none() ? 0 : reading.settings.dt;
  reading.heading_given = !heading.is_none();
  reading.closed = closed;
  Trajectory trajectory;
  check(callable, load_trajectory(file_name(path), reading, trajectory));
  warn_of_standstill(trajectory);
  return trajectory;
}

std::uint64_t draw_seed() {
  std::random_device device;
  return device();
}

// A seed from what NumPy calls rng: None, a number, or something that draws numbers.
py::object seed_from(const py::object& rng) {
  if (rng.is_none()) return py::int_(draw_seed());
  if (py::hasattr(rng, "integers")) return rng.attr("integers")(std::int64_t{1} << 53);
  return rng;
}

const std::vector<std::string> scenario_arguments = [] {
  std::vector<std::string> names = {"trajectory", "robot"};
  Scenario::fields([&](const auto& field) {
    names.emplace_back(std::string(field.name) == "seed" ? "rng" : field.name);
  });
  return names;
}();

// The scenario with the changes that the keywords ask for.
Scenario changed(const std::string& callable, Scenario scenario, py::dict arguments) {
  if (arguments.contains("rng")) {
    const Json seed = {{"seed", to_json(seed_from(arguments.attr("pop")("rng")))}};
    Outcome outcome = read_settings(seed, "", scenario);
    if (!outcome) outcome.message.replace(0, std::string("seed").size(), "rng");
    check(callable, outcome);
  }
  const auto take = [&](const char* name, auto& member) {
    using Member = std::decay_t<decltype(member)>;
    if (!arguments.contains(name)) return;
    const py::object value = arguments.attr("pop")(name);
    if (!py::isinstance<Member>(value)) {
      throw py::type_error(callable + ": " + name + " must be a " +
                           py::str(py::type::of<Member>().attr("__name__")).cast<std::string>());
    }
    member = value.cast<const Member&>();
  };
  take("trajectory", scenario.trajectory);
  take("robot", scenario.robot);
  const auto take_optional = [&](const char* name, auto& member) {
    if (!arguments.contains(name)) return;
    if (arguments[name].is_none()) {
      member.reset();
      arguments.attr("pop")(name);
      return;
    }
    std::decay_t<decltype(*member)> own;
    take(name, own);
    member = own;
  };
  take_optional("model", scenario.model);
  take_optional("motor", scenario.motor);
  check(callable, read_settings(to_json(arguments), "", scenario));
  check(callable, explain_consistency(scenario));
  return scenario;
}

// What the reference asks that the robot does not have is said where the scenario is made.
void warn_of_reference(const Scenario& scenario) {
  const py::object module = py::module_::import("nfopidn.robustness.reference_limits");
  for (const py::handle line : module.attr("told_at_construction")(scenario)) {
    const std::string text = "Scenario: " + py::cast<std::string>(line);
    if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
  }
}

Scenario make_scenario(const py::args& positional, const py::kwargs& keywords) {
  py::dict arguments = bind_arguments("Scenario", scenario_arguments, positional, keywords);
  if (!arguments.contains("trajectory")) {
    throw py::type_error("Scenario() needs a trajectory");
  }
  if (!arguments.contains("rng")) arguments["rng"] = py::none();
  Scenario scenario = changed("Scenario", Scenario{}, arguments);
  warn_of_reference(scenario);
  return scenario;
}

// Changes of the published scenario; those of its trajectory may be given by name too.
Scenario make_published(const py::kwargs& keywords) {
  const std::string callable = "Scenario.published";
  Json path = Json::object();
  py::dict arguments;
  const std::vector<std::string> path_arguments = named_path_arguments("ranunculoid");
  for (const auto& [key, value] : keywords) {
    const auto name = py::cast<std::string>(key);
    const bool of_path =
        std::find(path_arguments.begin(), path_arguments.end(), name) != path_arguments.end();
    if (of_path) {
      path[name] = to_json(value);
    } else {
      arguments[key] = value;
    }
  }
  arguments = bind_arguments(callable, scenario_arguments, py::args(), py::kwargs(arguments));
  if (arguments.contains("trajectory") && !path.empty()) {
    throw py::type_error(callable + "() takes a trajectory or '" + path.begin().key() +
                         "', not both");
  }
  if (!arguments.contains("rng")) arguments["rng"] = py::none();
  Scenario scenario = Scenario::published();
  check(callable, read_trajectory(path, "", scenario.trajectory));
  return changed(callable, std::move(scenario), arguments);
}

py::array reference_table(const Scenario& scenario) {
  const PreparedRun run = prepare(scenario);
  py::array_t<double> table({run.reference.size(), std::size_t{8}});
  auto cell = table.mutable_unchecked<2>();
  py::ssize_t k = 0;
  for (const ReferenceSample<double>& r : run.reference) {
    const double row[] = {r.x,     r.y,        r.theta,     r.v,
                          r.omega, r.tau_left, r.tau_right, r.reverse ? 1.0 : 0.0};
    for (py::ssize_t j = 0; j < 8; ++j) cell(k, j) = row[j];
    ++k;
  }
  return read_only(std::move(table));
}

std::string scenario_repr(const Scenario& s) {
  const std::string rest = arguments_text(s, false);
  return std::string("Scenario(") +
         ChoiceNames<Curve>::names[static_cast<int>(s.trajectory.settings.name)] + ", " +
         std::to_string(s.trajectory.size()) + " samples" + (rest.empty() ? "" : ", ") + rest + ")";
}

template <class Settings>
py::class_<Settings> bind_settings(py::module_& module, const std::string& text) {
  using S = Settings;
  const std::string name = settings_name<S>;
  const std::string doc = name + "(" + arguments_text(S{}, true) + ")\n--\n\n" + text +
                          "\n\nParameters\n----------\n" + parameters_text<S>(field_names<S>());
  py::class_<S> cls(module, name.c_str(), py::is_final(), doc.c_str());
  cls.def(py::init([name](const py::args& positional, const py::kwargs& keywords) {
    return read_own<S>(to_json(bind_arguments(name, field_names<S>(), positional, keywords)));
  }));
  add_fields<S>(cls, [](const S& self) -> const S& { return self; });
  cls.def(
      "replace",
      [name](const S& self, const py::kwargs& changes) {
        S settings = self;
        const std::string callable = name + ".replace";
        check(
            callable,
            read_settings(to_json(bind_arguments(callable, field_names<S>(), py::args(), changes)),
                          "", settings));
        return settings;
      },
      "replace(self, **changes)\n--\n\nA copy with some parameters changed.");
  cls.def("__repr__",
          [name](const S& self) { return name + "(" + arguments_text(self, true) + ")"; });
  add_value_semantics<S>(cls, write_settings<S>, read_own<S>);
  return cls;
}

void bind_motor(py::module_& module) {
  using M = Motor<double>;
  py::class_<M> cls = bind_settings<M>(
      module,
      "A DC motor with its gear, the same behind each wheel (docs/theory.md). The inductance of "
      "the winding\nis neglected.");
  cls.def(
      "voltage",
      [](const M& self, double torque, double wheel_speed) {
        return self.voltage(torque, wheel_speed);
      },
      py::arg("torque"), py::arg("wheel_speed"),
      "voltage(self, torque, wheel_speed)\n--\n\nThe voltage [V] at which the motor gives a "
      "torque [N m] at a wheel that turns with wheel_speed\n[rad/s], within the supply's. The "
      "bearings' friction and the dead band are not made up for.");
  cls.def(
      "available",
      [](const M& self, double torque, double wheel_speed) {
        return self.available(torque, wheel_speed);
      },
      py::arg("torque"), py::arg("wheel_speed"),
      "available(self, torque, wheel_speed)\n--\n\nThe torque [N m] as the supply can give it "
      "at a wheel that turns with wheel_speed [rad/s].");
  cls.def(
      "pulse_width",
      [](const M& self, double voltage, int full_scale) {
        if (!std::isfinite(voltage)) {
          throw py::value_error("pulse_width: voltage is " + number_text(voltage) +
                                "; must be finite");
        }
        if (full_scale < 1) {
          throw py::value_error("pulse_width: full_scale is " + std::to_string(full_scale) +
                                "; must be 1 or more");
        }
        return pulse_width(self, voltage, full_scale);
      },
      py::arg("voltage"), py::arg("full_scale"),
      "pulse_width(self, voltage, full_scale)\n--\n\nCounts of a pulse-width modulator, of which "
      "full_scale is the supply's voltage: the nearest\nwhole number, within +-full_scale.");
}

}  // namespace

void bind_robot(py::module_& module) {
  using R = Robot<double>;
  py::class_<R> cls =
      bind_settings<R>(module, "A differential-drive robot; the default is the paper's Eddie.");
  cls.def_static("eddie", &R::eddie, "eddie()\n--\n\nThe paper's robot (its Table 1).");
  cls.def_static(
      "eddie_datasheet", &R::eddie_datasheet,
      "eddie_datasheet()\n--\n\nThe same robot by its vendor's datasheet: track 0.390 m, "
      "inertia of a disc.");
  cls.def(
      "with_wheels",
      [](const R& self, double wheel_inertia) {
        const Range range = between(0, 1e3);
        if (!range.contains(wheel_inertia)) {
          raise("with_wheels", refuse_number("wheel_inertia", wheel_inertia, range, "kg m^2"));
        }
        const R loaded = with_wheels(self, wheel_inertia);
        R checked = loaded;
        check("with_wheels", read_settings(write_settings(loaded), "", checked));
        return loaded;
      },
      py::arg("wheel_inertia"),
      "with_wheels(self, wheel_inertia)\n--\n\nA copy with what the wheels' spin adds "
      "(docs/theory.md): 2 J/r^2 to the mass and J L^2/(2 r^2)\nto the inertia, for the inertia J "
      "[kg m^2], in [0, 1000], of each wheel about its axle and of\nwhat turns with it. The "
      "wheels' "
      "own mass is the robot's already. ValueError: wheel_inertia, or\nwhat it makes of the robot, "
      "is out of range.");
  bind_motor(module);
}

void bind_trajectory(py::module_& module) {
  using T = Trajectory;
  py::class_<T> cls(module, "Trajectory", py::is_final(),
                    "A sampled reference trajectory. Made by its class methods, one a path.\n\n"
                    "Arrays are read-only, one number a sample: t [s], x, y [m], theta [rad], v "
                    "[m/s],\nomega [rad/s], acceleration [m/s^2], turn_acceleration [rad/s^2], "
                    "reverse.");
  for (const char* name : ChoiceNames<Curve>::names) {
    const std::string path = name;
    if (path == "samples") continue;
    cls.def_static(
        name,
        [path](const py::args& positional, const py::kwargs& keywords) {
          return named_path(path, positional, keywords);
        },
        named_path_doc(path).c_str());
  }
  cls.def_static(
      "from_samples", &from_samples, py::arg("x"), py::arg("y"), py::arg("dt"),
      py::arg("heading") = "forward", py::arg("laps") = 1, py::arg("theta") = py::none(),
      py::arg("reverse") = py::none(), py::arg("closed") = false,
      py::arg("standstill_speed") = py::none(), py::arg("origin") = py::make_tuple(0, 0),
      "from_samples(x, y, dt, heading='forward', laps=1, theta=None, reverse=None, closed=False, "
      "standstill_speed=None, origin=(0, 0))\n--\n\n"
      "A path through positions x, y (N,) [m], dt [s] apart, N >= 3. More than one lap needs a\n"
      "closed path; `closed` adds the first point at the end, a step after the last, if it is not\n"
      "there. The heading is that of the motion unless theta (N,) [rad] gives it; reverse (N,) is\n"
      "true where the robot drives backwards. Slower than standstill_speed [m/s] the heading of\n"
      "the motion holds; None: the speed at which the positions' last digit, or their noise at\n"
      "rest, hides the direction, with a UserWarning that says at how many samples. origin (2,)\n"
      "[m] is what was taken off the positions, which writers add again. ValueError names the\n"
      "sample or argument at fault, such as a masked or complex one.");
  cls.def_static(
      "from_csv", &from_csv, py::arg("path"), py::arg("heading") = py::none(), py::arg("laps") = 1,
      py::arg("dt") = py::none(), py::arg("closed") = false,
      py::arg("standstill_speed") = py::none(),
      "from_csv(path, heading=None, laps=1, dt=None, closed=False, standstill_speed=None)\n--\n\n"
      "A path from a table with columns x, y [m] and a time in equal steps or, without one, dt "
      "[s]\n"
      "apart. Commas, semicolons, tabs or blanks separate; # begins a comment; names may have\n"
      "units (`x_m`, `t [ms]`), and a time be called t, time, timestamp, stamp or sec. Columns\n"
      "reverse and theta (or yaw) are used, the latter unless heading is given. `notes` says what\n"
      "was made of each column. The rest is as of from_samples(). ValueError names file and line.");
  // Written in Python, where SciPy's splines are.
  const auto from_python = [&](const char* name, const std::string& text) {
    cls.def_static(
        name,
        [name](const py::args& positional, const py::kwargs& keywords) {
          const py::object trajectories = py::module_::import("nfopidn.trajectories");
          return trajectories.attr(name)(*positional, **keywords);
        },
        (name + text).c_str());
  };
  from_python("from_waypoints",
              "(points, limits, dt, robot=None, theta=None, speed=None, reverse=None, dwell=None, "
              "closed=False, laps=1, tolerance=0.0, corner=2.0, smoothing=None)\n--\n\n"
              "The fastest trajectory through points (N, 2) [m] within the limits, from rest to\n"
              "rest: nfopidn.trajectories.from_waypoints(), which has the parameters.");
  from_python("from_states",
              "(t, x, y, theta=None, v=None, omega=None, dt=None, speed_limit=None, "
              "standstill_speed=None)\n--\n\n"
              "A trajectory from a log with uneven stamps t (N,) [s], positions x, y (N,) [m]:\n"
              "nfopidn.trajectories.from_states(), which has the parameters.");
  cls.def_property_readonly(
      "origin", [](const T& self) { return py::make_tuple(self.origin[0], self.origin[1]); },
      "what was taken off the positions [m]; writers of nfopidn.formats add it");
  cls.def_property_readonly(
      "notes",
      [](const T& self) {
        py::tuple notes(self.notes.size());
        for (std::size_t i = 0; i < self.notes.size(); ++i) notes[i] = printable(self.notes[i]);
        return notes;
      },
      "how the path was read and what was made of it, in lines; () of a copy");
  cls.def_property_readonly(
      "t",
      [](const T& self) -> py::array {
        py::array_t<double> t(self.size());
        for (py::ssize_t k = 0; k < self.size(); ++k)
          t.mutable_at(k) = static_cast<double>(k) * self.dt();
        return read_only(std::move(t));
      },
      "times [s]");
  const auto array = [&](const char* name, Eigen::ArrayXd T::*member, const char* text) {
    cls.def_property_readonly(
        name,
        [member](const py::object& self) { return view(self.cast<const T&>().*member, self); },
        text);
  };
  array("x", &T::x, "[m]");
  array("y", &T::y, "[m]");
  array("theta", &T::theta, "unwrapped heading [rad]");
  array("v", &T::v, "speed, signed along the heading [m/s]");
  array("omega", &T::omega, "[rad/s]");
  array("acceleration", &T::acceleration, "dv/dt [m/s^2]");
  array("turn_acceleration", &T::turn_acceleration, "d(omega)/dt [rad/s^2]");
  cls.def_property_readonly(
      "reverse",
      [](const T& self) -> py::array {
        py::array_t<bool> flags(self.size());
        for (py::ssize_t k = 0; k < self.size(); ++k) {
          flags.mutable_at(k) = self.reverse[static_cast<std::size_t>(k)] != 0;
        }
        return read_only(std::move(flags));
      },
      "where the reference drives backwards");
  add_fields<TrajectorySettings>(
      cls, [](const T& self) -> const TrajectorySettings& { return self.settings; });
  cls.def_property_readonly("peak_speed", &T::peak_speed, "largest |v| [m/s]");
  cls.def("__len__", [](const T& self) { return self.size(); });
  cls.def("__repr__", [](const T& self) {
    return "Trajectory." +
           std::string(ChoiceNames<Curve>::names[static_cast<int>(self.settings.name)]) + "(" +
           std::to_string(self.size()) + " samples, dt=" + number_text(self.dt()) + ", heading='" +
           ChoiceNames<HeadingChoice>::names[static_cast<int>(self.settings.heading)] + "')";
  });
  add_value_semantics<T>(cls, write_trajectory, trajectory_from_json);
}

void bind_tables(py::module_& module) {
  module.def(
      "annotate",
      [](const Trajectory& trajectory, const std::vector<std::string>& notes) {
        Trajectory copy = trajectory;
        copy.notes = notes;
        return copy;
      },
      py::arg("trajectory"), py::arg("notes"));
  module.def(
      "read_table",
      [](const py::object& path) {
        const std::string name = file_name(path);
        std::string text;
        csv::Table table;
        check("read_table", read_file(name, text));
        check("read_table", csv::parse(name, text, table));
        py::list rows;
        for (const std::string_view row : table.rows) {
          py::list cells;
          for (const std::string_view cell : csv::split(row, table.separator)) {
            cells.append(printable(std::string(cell)));
          }
          rows.append(std::move(cells));
        }
        py::list names;
        for (const std::string& column : table.names) names.append(printable(column));
        return py::make_tuple(names, table.lines, rows);
      },
      py::arg("path"));
  module.def(
      "column_meaning",
      [](const std::string& name) {
        const csv::Meaning meaning = csv::meaning_of(name);
        return py::make_tuple(meaning.quantity, meaning.factor);
      },
      py::arg("name"));
}

void bind_scenario(py::module_& module) {
  using S = Scenario;
  const std::string doc =
      "Scenario(trajectory, robot=Robot(), " +
      [] {
        std::string text = arguments_text(Scenario{}, true);
        return text.replace(text.find("seed=0"), 6, "rng=None");
      }() +
      ")\n--\n\nEverything about a run but the controller. ValueError names what is wrong; a\n"
      "UserWarning tells what the reference asks that the robot does not have.\n\n"
      "Parameters\n----------\ntrajectory\n    a Trajectory\nrobot\n    a Robot\n" +
      parameters_text<S>(scenario_arguments) +
      "rng\n    a seed, a numpy.random.Generator, or None to draw a seed, which the attribute "
      "`seed` "
      "records.\n";
  py::class_<S> cls(module, "Scenario", py::is_final(), doc.c_str());
  cls.def(py::init(&make_scenario));
  cls.def_static("published", &make_published,
                 "published(**changes)\n--\n\nThe scenario of the paper's figures, with changes: "
                 "arguments of Scenario, or of\nTrajectory.ranunculoid.");
  cls.def(
      "to_json", [](const S& self) { return write_scenario(self).dump(); },
      "to_json(self)\n--\n\nThe text that save() writes, on one line.");
  cls.def_static(
      "from_json",
      [](const std::string& text) {
        Json document;
        S scenario = default_scenario();
        check("Scenario.from_json", parse_json(text, document));
        check("Scenario.from_json", read_scenario(document, scenario));
        return scenario;
      },
      py::arg("text"), "from_json(text)\n--\n\nThe inverse of to_json.");
  cls.def_static(
      "load",
      [](const py::object& path) {
        S scenario = default_scenario();
        check("Scenario.load", load_scenario(file_name(path), scenario));
        return scenario;
      },
      py::arg("path"), "load(path)\n--\n\nReads a scenario file (JSON).");
  cls.def(
      "save",
      [](const S& self, const py::object& path) {
        check("Scenario.save", write_file(file_name(path), document_text(write_scenario(self))));
      },
      py::arg("path"), "save(self, path)\n--\n\nWrites a scenario file (JSON).");
  cls.def(
      "replace",
      [](const S& self, const py::kwargs& changes) {
        return changed("Scenario.replace", self,
                       bind_arguments("Scenario.replace", scenario_arguments, py::args(), changes));
      },
      "replace(self, **changes)\n--\n\nA copy with some arguments changed.");
  cls.def(
      "variations",
      [](const py::object& self, const py::args& which, const py::kwargs& changes) {
        const py::object variations = py::module_::import("nfopidn.families").attr("variations");
        return variations(self, *which, **changes);
      },
      "variations(self, which=None, **changes)\n--\n\nThe scenario and its plant a little other, "
      "as a Family: nfopidn.families.variations(),\nwhich has the parameters.");
  cls.def_readonly("trajectory", &S::trajectory, "the Trajectory");
  cls.def_readonly("robot", &S::robot, "the Robot");
  add_fields<S>(cls, [](const S& self) -> const S& { return self; });
  cls.def_property_readonly("reference", &reference_table,
                            "(N, 8): x, y, theta, v, omega, tau_left, tau_right, reverse, as "
                            "Controller.step takes a row");
  cls.def("__repr__", &scenario_repr);
  add_value_semantics<S>(cls, write_scenario, scenario_from_json);
}

}  // namespace nfopidn::python
