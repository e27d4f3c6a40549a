// Rival: the controllers that NFOPIDN is compared with.
#include <pybind11/stl.h>

#include "nfopidn/io/json_rival.hpp"
#include "stepping.hpp"

namespace nfopidn::python {

namespace {

using Design = rivals::RivalDesign;

Design read_py_rival(const Json& document) {
  Design design;
  check("Rival", read_rival(document, design));
  return design;
}

const Robot<double>& robot_of(const std::string& callable, const py::handle& value) {
  if (py::isinstance<Robot<double>>(value)) return value.cast<const Robot<double>&>();
  throw py::type_error(callable + ": robot must be a Robot");
}

// The law's parameters and the settings beside them, from keywords.
Design changed(const std::string& callable, Design design, const py::dict& keywords) {
  Json parameters = Json::object();
  if (keywords.contains("integral")) {
    Json one = Json::object();
    one["integral"] = to_json(py::object(keywords["integral"]));
    const bool before = design.integral;
    check(callable, read_settings(one, "", design));
    // Its gains come last; those that are not given are zero.
    const std::size_t size = rivals::law_bounds(design.law, design.integral).size();
    if (design.integral != before) design.parameters.resize(size, 0.0);
  }
  const std::vector<ParameterBounds> bounds = rivals::law_bounds(design.law, design.integral);
  for (std::size_t i = 0; i < bounds.size(); ++i) parameters[bounds[i].name] = design.parameters[i];
  Json settings = Json::object();
  std::vector<std::string> known = field_names<Design>();
  known.emplace_back("robot");
  for (const ParameterBounds& b : bounds) known.push_back(b.name);
  const py::dict bound = bind_arguments(callable, known, py::args(), keywords);
  for (const auto& [key, value] : bound) {
    const auto name = py::cast<std::string>(key);
    if (name == "robot") {
      if (!value.is_none()) design.robot = robot_of(callable, value);
      continue;
    }
    py::dict one;
    one[key] = value;
    Json& place = parameters.contains(name) ? parameters : settings;
    place.update(to_json(one));
  }
  check(callable, read_rival_parameters(parameters, design));
  check(callable, read_settings(settings, "", design));
  return design;
}

Design make_rival(const std::string& law, const py::kwargs& keywords) {
  Design design;
  check("Rival", find_law(law, design.law));
  design.parameters = rivals::default_parameters(design.law);
  return changed("Rival", design, keywords);
}

py::dict parameters(const Design& self) {
  py::dict result;
  std::size_t place = 0;
  for (const ParameterBounds& b : rivals::law_bounds(self.law, self.integral)) {
    result[py::str(b.name)] = self.parameters[place++];
  }
  return result;
}

std::string repr(const Design& self) {
  std::string text = "Rival('" + rivals::law_name(self.law) + "'";
  if (self.speeds == rivals::Speeds::differenced) text += ", speeds='differenced'";
  if (self.integral) text += ", integral=True";
  std::size_t place = 0;
  for (const ParameterBounds& b : rivals::law_bounds(self.law, self.integral)) {
    text += ", " + b.name + "=" + number_text(self.parameters[place++]);
  }
  return text + ")";
}

// Name, unit, low, high and one line of each parameter of a law.
py::list describe(const std::string& law, bool integral) {
  std::size_t place = 0;
  check("Rival", find_law(law, place));
  py::list rows;
  rivals::for_each_parameter(place, integral, [&](const auto& f) {
    rows.append(py::make_tuple(f.name, f.unit, f.range.low, f.range.high, f.text));
  });
  return rows;
}

void start_rival(PyRival& self, const Scenario& scenario) {
  const ControlLimits<double> limits = limits_of(scenario);
  self.running = rivals::make_rival(
      self.design, {self.design.robot, limits.sample_time, limits.speed_scale}, limits.torque);
  self.running->reset();
  self.torque_limit = limits.torque;
}

py::tuple step_rival(PyRival& self, const py::object& measurement, const py::object& reference,
                     const py::object& torque_limit) {
  const std::string callable = "Rival.step";
  const auto [measured, wanted] = step_arguments(callable, measurement, reference);
  if (!self.running) {
    throw py::value_error(callable +
                          ": the sample time and the path's peak speed are unknown; call "
                          "start(scenario) first");
  }
  const double limit = step_limit(callable, torque_limit, self.torque_limit);
  if (limit != self.torque_limit) self.running->set_torque_limit(limit);
  self.torque_limit = limit;
  const TorquePair<double> torque = self.running->step(measured, wanted);
  return py::make_tuple(torque.left, torque.right);
}

py::tuple feedback_of_rival(const PyRival& self) {
  const TorquePair<double> torque =
      self.running ? self.running->feedback() : TorquePair<double>{0, 0};
  return py::make_tuple(torque.left, torque.right);
}

void bind_stepping(py::class_<PyRival>& cls) {
  cls.def("start", &start_rival, Computes(), py::arg("scenario"),
          "start(self, scenario)\n--\n\nMakes ready for a run of the scenario as simulate() does "
          "it: at rest, with the scenario's torque limit,\nsample time and peak speed.");
  cls.def("step", &step_rival, Computes(), py::arg("measurement"), py::arg("reference"),
          py::arg("torque_limit") = py::none(),
          "step(self, measurement, reference, torque_limit=None)\n--\n\nThe limited torques (left, "
          "right) [N m] of one sample, as Controller.step() gives them. A law whose\nspeeds are "
          "'measured' reads v [m/s] and omega [rad/s] of the measurement; left out they are 0.\n"
          "torque_limit [N m]: None is the limit of before. ValueError: start() has not been "
          "called, or what is\nnot finite; the memory is then as before.");
  cls.def(
      "reset",
      [](PyRival& self) {
        if (self.running) self.running->reset();
      },
      "reset(self)\n--\n\nForgets what was measured and summed up.");
  cls.def("feedback", &feedback_of_rival,
          "feedback(self)\n--\n\nThe unlimited feedback part of the last step's torques [N m].");
}

}  // namespace

void bind_rivals(py::module_& module) {
  py::class_<PyRival> cls(
      module, "Rival", py::is_final(),
      "Rival(law, **settings)\n--\n\nA controller to compare "
      "with: one of Rival.laws(), docs/rivals.md has their equations.\n\nParameters\n----------\n"
      "law\n    One of Rival.laws().\n**settings\n    speeds: 'measured', the law is given v and "
      "omega, or 'differenced', it takes them from the last\n    two poses. robot: the Robot that "
      "its torques are computed for, by default Robot.eddie(). And\n    the law's own parameters, "
      "see Rival.describe(law): those left out are the best found for the\n    published "
      "scenario.\n\nRaises\n------\n"
      "ValueError\n    Unknown law, a parameter out of its range.");
  cls.def(py::init([](const std::string& law, const py::kwargs& keywords) {
            return PyRival(make_rival(law, keywords));
          }),
          py::arg("law"));
  cls.def_static("laws", &rivals::law_names, "laws()\n--\n\nThe names of all laws.");
  cls.def_static(
      "describe", &describe, py::arg("law"), py::arg("integral") = false,
      "describe(law, integral=False)\n--\n\nName, unit, low, high and meaning of each "
      "parameter, with integral action also of\nits gains; the bounds are those of tune().");
  cls.def_property_readonly(
      "law", [](const PyRival& self) { return rivals::law_name(self.design.law); }, "its name");
  cls.def_property_readonly(
      "parameters", [](const PyRival& self) { return parameters(self.design); },
      "dict of the law's parameters");
  cls.def_property_readonly(
      "robot", [](const PyRival& self) { return self.design.robot; },
      "the model behind the torques");
  add_fields<Design>(cls, [](const PyRival& self) -> const Design& { return self.design; });
  cls.def(
      "replace",
      [](const PyRival& self, const py::kwargs& keywords) {
        return PyRival(changed("Rival.replace", self.design, keywords));
      },
      "replace(self, **changes)\n--\n\nA copy with some parameters or settings changed.");
  cls.def(
      "to_json", [](const PyRival& self) { return write_rival(self.design).dump(); },
      "to_json(self)\n--\n\nThe text that save() writes, on one line.");
  cls.def_static(
      "from_json",
      [](const std::string& text) {
        Json document;
        check("Rival.from_json", parse_json(text, document));
        return PyRival(read_py_rival(document));
      },
      py::arg("text"), "from_json(text)\n--\n\nThe inverse of to_json.");
  cls.def(
      "save",
      [](const PyRival& self, const py::object& path) {
        check("Rival.save", write_file(file_name(path), document_text(write_rival(self.design))));
      },
      py::arg("path"), "save(self, path)\n--\n\nWrites a rival file (JSON).");
  cls.def_static(
      "load",
      [](const py::object& path) {
        Design design;
        check("Rival.load", load_document(file_name(path), read_rival, design));
        return PyRival(std::move(design));
      },
      py::arg("path"), "load(path)\n--\n\nReads a rival file (JSON).");
  bind_stepping(cls);
  cls.def("__repr__", [](const PyRival& self) { return repr(self.design); });
  add_value_semantics<PyRival>(
      cls, [](const PyRival& self) { return write_rival(self.design); },
      [](const Json& document) { return PyRival(read_py_rival(document)); });
}

}  // namespace nfopidn::python
