// Rival: the controllers that NFOPIDN is compared with.
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "nfopidn/io/json_rival.hpp"

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

}  // namespace

void bind_rivals(py::module_& module) {
  py::class_<Design> cls(
      module, "Rival", py::is_final(),
      "Rival(law, **settings)\n--\n\nA controller to compare "
      "with: one of Rival.laws(), docs/rivals.md has their equations.\n\nParameters\n----------\n"
      "law\n    One of Rival.laws().\n**settings\n    speeds: 'measured', the law is given v and "
      "omega, or 'differenced', it takes them from the last\n    two poses. robot: the Robot that "
      "its torques are computed for, by default Robot.eddie(). And\n    the law's own parameters, "
      "see Rival.describe(law): those left out are the best found for the\n    published "
      "scenario.\n\nRaises\n------\n"
      "ValueError\n    Unknown law, a parameter out of its range.");
  cls.def(py::init(&make_rival), py::arg("law"));
  cls.def_static("laws", &rivals::law_names, "laws()\n--\n\nThe names of all laws.");
  cls.def_static(
      "describe", &describe, py::arg("law"), py::arg("integral") = false,
      "describe(law, integral=False)\n--\n\nName, unit, low, high and meaning of each "
      "parameter, with integral action also of\nits gains; the bounds are those of tune().");
  cls.def_property_readonly(
      "law", [](const Design& self) { return rivals::law_name(self.law); }, "its name");
  cls.def_property_readonly("parameters", &parameters, "dict of the law's parameters");
  cls.def_readonly("robot", &Design::robot, "the model behind the torques");
  add_fields<Design>(cls, [](const Design& self) -> const Design& { return self; });
  cls.def(
      "replace",
      [](const Design& self, const py::kwargs& keywords) {
        return changed("Rival.replace", self, keywords);
      },
      "replace(self, **changes)\n--\n\nA copy with some parameters or settings changed.");
  cls.def(
      "to_json", [](const Design& self) { return write_rival(self).dump(); },
      "to_json(self)\n--\n\nThe text that save() writes, on one line.");
  cls.def_static(
      "from_json",
      [](const std::string& text) {
        Json document;
        check("Rival.from_json", parse_json(text, document));
        return read_py_rival(document);
      },
      py::arg("text"), "from_json(text)\n--\n\nThe inverse of to_json.");
  cls.def(
      "save",
      [](const Design& self, const py::object& path) {
        check("Rival.save", write_file(file_name(path), document_text(write_rival(self))));
      },
      py::arg("path"), "save(self, path)\n--\n\nWrites a rival file (JSON).");
  cls.def_static(
      "load",
      [](const py::object& path) {
        Design design;
        check("Rival.load", load_document(file_name(path), read_rival, design));
        return design;
      },
      py::arg("path"), "load(path)\n--\n\nReads a rival file (JSON).");
  cls.def("__repr__", &repr);
  add_value_semantics<Design>(
      cls, [](const Design& self) { return write_rival(self); }, read_py_rival);
}

}  // namespace nfopidn::python
