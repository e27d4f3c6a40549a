// Python objects to JSON and back, so that keywords pass through the same reader as files.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "nfopidn/io/json.hpp"

namespace nfopidn::python {

namespace py = pybind11;

[[noreturn]] inline void raise(const std::string& where, const Outcome& outcome) {
  throw py::value_error(where + ": " + printable(outcome.message));
}

inline void check(const std::string& where, const Outcome& outcome) {
  if (!outcome) raise(where, outcome);
}

constexpr int deepest_argument = 8;  // lists in lists

inline Json to_json(const py::handle& object, int depth = 0) {
  PyObject* const raw = object.ptr();
  if (depth > deepest_argument) throw py::value_error("nested too deeply");
  if (object.is_none()) return nullptr;
  if (PyBool_Check(raw)) return raw == Py_True;
  if (PyUnicode_Check(raw)) {
    Py_ssize_t size = 0;
    const char* text = PyUnicode_AsUTF8AndSize(raw, &size);
    if (text != nullptr) return std::string(text, static_cast<std::size_t>(size));
    PyErr_Clear();
    throw py::value_error("text that is no Unicode");
  }
  if (PyLong_Check(raw)) {
    int overflow = 0;
    const long long value = PyLong_AsLongLongAndOverflow(raw, &overflow);
    if (overflow == 0) return value;
    const double number = PyLong_AsDouble(raw);
    if (PyErr_Occurred() == nullptr) return number;
    PyErr_Clear();  // beyond every float
    return overflow * std::numeric_limits<double>::infinity();
  }
  if (PyFloat_Check(raw)) return PyFloat_AS_DOUBLE(raw);
  if (py::hasattr(object, "tolist")) return to_json(object.attr("tolist")(), depth + 1);  // NumPy
  if (PyList_Check(raw) || PyTuple_Check(raw)) {
    Json list = Json::array();
    for (const py::handle& element : py::reinterpret_borrow<py::sequence>(object)) {
      list.push_back(to_json(element, depth + 1));
    }
    return list;
  }
  throw py::type_error("a number, word or list is needed, not " +
                       py::str(py::type::of(object)).cast<std::string>());
}

// The name of a file from whatever os.fspath() takes.
inline std::string file_name(const py::object& path) {
  const py::module_ os = py::module_::import("os");
  auto name = os.attr("fsencode")(path).cast<std::string>();
  if (name.find('\0') != std::string::npos) {
    throw py::value_error("the path holds a null byte");
  }
  return name;
}

inline py::array read_only(py::array array) {
  array.attr("flags").attr("writeable") = false;
  return array;
}

// Lists of numbers become tuples, lists of lists read-only arrays.
inline py::object from_json(const Json& value) {
  if (value.is_null()) return py::none();
  if (value.is_boolean()) return py::bool_(value.get<bool>());
  if (value.is_string()) return py::str(value.get<std::string>());
  if (value.is_number_float()) return py::float_(value.get<double>());
  if (value.is_number()) return py::int_(value.get<std::int64_t>());
  if (value.is_object()) {
    py::dict result;
    for (const auto& item : value.items()) result[py::str(item.key())] = from_json(item.value());
    return result;
  }
  if (!value.empty() && value[0].is_array()) {
    py::array_t<double> rows({value.size(), value[0].size()});
    auto element = rows.mutable_unchecked<2>();
    for (std::size_t i = 0; i < value.size(); ++i) {
      for (std::size_t j = 0; j < value[i].size(); ++j) {
        element(static_cast<py::ssize_t>(i), static_cast<py::ssize_t>(j)) =
            value[i][j].get<double>();
      }
    }
    return read_only(std::move(rows));
  }
  py::tuple result(value.size());
  for (std::size_t i = 0; i < value.size(); ++i) result[i] = from_json(value[i]);
  return result;
}

// A read-only view of `rows` x `columns` doubles that keeps `owner` alive.
inline py::array view(const double* data, std::vector<py::ssize_t> shape,
                      std::vector<py::ssize_t> strides, const py::handle& owner) {
  for (py::ssize_t& stride : strides) stride *= static_cast<py::ssize_t>(sizeof(double));
  return read_only(
      py::array(py::dtype::of<double>(), std::move(shape), std::move(strides), data, owner));
}

inline py::array view(const Eigen::ArrayXd& array, const py::handle& owner) {
  return view(array.data(), {array.size()}, {1}, owner);
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

// An array of real numbers. Masked, complex and text elements are no numbers.
inline Numbers real_numbers(const std::string& callable, const std::string& name,
                            const py::handle& object) {
  const std::string begin = callable + ": " + name;
  const bool plain = PyList_Check(object.ptr()) || PyTuple_Check(object.ptr());
  if (!plain && py::hasattr(object, "mask")) {
    const py::object mask = py::module_::import("numpy.ma").attr("getmaskarray")(object);
    const py::object first = mask.attr("ravel")().attr("argmax")();
    if (mask.attr("any")().cast<bool>()) {
      throw py::value_error(begin + "[" + py::str(first).cast<std::string>() +
                            "] is masked; must be a number");
    }
  }
  const auto array = py::array::ensure(object);
  const char kind = array ? array.dtype().kind() : '\0';
  if (!array) PyErr_Clear();
  if (kind == 'c') throw py::value_error(begin + " is complex; must be real numbers");
  const bool numbers = kind == 'b' || kind == 'i' || kind == 'u' || kind == 'f' || kind == 'O';
  const auto result = numbers ? Numbers::ensure(array) : Numbers();
  if (!numbers || !result) {
    PyErr_Clear();
    throw py::type_error(begin + " must be an array of numbers");
  }
  return result;
}

// The arguments of a call by name, positional ones taking the names in order.
inline py::dict bind_arguments(const std::string& callable, const std::vector<std::string>& names,
                               const py::args& positional, const py::kwargs& keywords) {
  if (positional.size() > names.size()) {
    throw py::type_error(callable + "() takes at most " + std::to_string(names.size()) +
                         " positional arguments, got " + std::to_string(positional.size()));
  }
  py::dict bound;
  for (std::size_t i = 0; i < positional.size(); ++i) bound[py::str(names[i])] = positional[i];
  for (const auto& [key, value] : keywords) {
    const auto name = py::cast<std::string>(key);
    if (bound.contains(key)) {
      throw py::type_error(callable + "() got two values for argument '" + name + "'");
    }
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      throw py::type_error(callable + "() has no argument '" + name + "'" +
                           suggestion(name, names) + "; known: " + json::list_text(names));
    }
    bound[key] = value;
  }
  return bound;
}

inline Json to_json(const py::dict& arguments) {
  Json object = Json::object();
  for (const auto& [key, value] : arguments) {
    const auto name = py::cast<std::string>(key);
    try {
      object[name] = to_json(value);
    } catch (const py::type_error& error) {
      throw py::type_error(name + ": " + error.what());
    } catch (const py::value_error& error) {
      throw py::value_error(name + ": " + error.what());
    }
  }
  return object;
}

template <class Settings>
std::vector<std::string> field_names() {
  std::vector<std::string> names;
  Settings::fields([&](const auto& field) { names.emplace_back(field.name); });
  return names;
}

template <class Settings>
py::object field_value(const Settings& settings, const std::string& name) {
  py::object result = py::none();
  Settings::fields([&](const auto& field) {
    if (name != field.name) return;
    using Value = std::decay_t<decltype(settings.*field.member)>;
    if constexpr (std::is_same_v<Value, std::optional<Robot<double>>> ||
                  std::is_same_v<Value, std::optional<Motor<double>>>) {
      if (const auto& own = settings.*field.member) result = py::cast(*own);
    } else {
      result = from_json(json::write(settings.*field.member));
    }
  });
  return result;
}

// A read-only property for every field of the settings struct that `get` finds in the object.
template <class Settings, class Class, class Get>
void add_fields(Class& cls, const Get& get) {
  using Object = typename Class::type;
  Settings::fields([&](const auto& field) {
    const std::string name = field.name;
    const std::string unit = *field.unit == '\0' ? "" : " [" + std::string(field.unit) + "]";
    cls.def_property_readonly(
        field.name, [get, name](const Object& self) { return field_value(get(self), name); },
        (field.text + unit).c_str());
  });
}

inline std::string literal(const Json& value) {
  if (value.is_object()) {  // the settings within settings are a robot's or a motor's
    const std::string begin = value.contains("mass") ? "Robot(" : "Motor(";
    std::string text;
    for (const auto& item : value.items()) {
      text += (text.empty() ? begin : ", ") + item.key() + "=" + item.value().dump();
    }
    return text + ")";
  }
  if (value.is_null()) return "None";
  if (value.is_boolean()) return value.get<bool>() ? "True" : "False";
  if (value.is_string()) return "'" + value.get<std::string>() + "'";
  return value.dump();
}

// The fields as arguments of a call. With `all` false: those that differ from the default, long
// lists cut short.
template <class Settings>
std::string arguments_text(const Settings& settings, bool all) {
  constexpr std::size_t longest = 60;
  const Json defaults = write_settings(Settings{});
  const Json values = write_settings(settings);
  std::string text;
  for (const auto& item : values.items()) {
    if (!all && item.value() == defaults[item.key()]) continue;
    std::string value = literal(item.value());
    if (!all && value.size() > longest) value = value.substr(0, longest - 3) + "...";
    text += (text.empty() ? "" : ", ") + item.key() + "=" + value;
  }
  return text;
}

// numpydoc's list of parameters, from the schema: of the fields that are among `names`.
template <class Settings>
std::string parameters_text(const std::vector<std::string>& names) {
  const Settings defaults;
  std::string text;
  Settings::fields([&](const auto& field) {
    using Value = std::remove_const_t<std::remove_reference_t<decltype(defaults.*field.member)>>;
    if (std::find(names.begin(), names.end(), field.name) == names.end()) return;
    text += std::string(field.name) + "\n    " + field.text;
    if (*field.unit != '\0') text += " [" + std::string(field.unit) + "]";
    if constexpr (std::is_enum_v<Value>) {
      text += "; " + json::choice_list<Value>();
    } else if (std::isfinite(field.range.low) || std::isfinite(field.range.high)) {
      text += "; " + range_text(field.range);
    }
    text += ". Default: " + literal(json::write(defaults.*field.member)) + ".\n";
  });
  return text;
}

}  // namespace nfopidn::python
