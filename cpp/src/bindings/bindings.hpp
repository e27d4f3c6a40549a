// The parts of the Python module, each a translation unit.
#pragma once

#include <memory>

#include "convert.hpp"
#include "nfopidn/io/csv.hpp"
#include "nfopidn/simulate.hpp"

namespace nfopidn::python {

using RuntimeController = Controller<double, Fir<double, maximum_memory + 2, maximum_memory>,
                                     TrackingStructure<double>>;

// A controller's settings, and the law at work once step() is called.
struct PyController {
  ControllerDesign settings;
  // One of them, by the memory.
  std::unique_ptr<RuntimeController> running;
  std::unique_ptr<LongController> running_long;
  double torque_limit = 0;

  PyController() = default;
  explicit PyController(const ControllerDesign& given) : settings(given) {}
};

void bind_files(py::module_& module);
void bind_robot(py::module_& module);
void bind_trajectory(py::module_& module);
void bind_scenario(py::module_& module);
void bind_controller(py::module_& module);
void bind_rivals(py::module_& module);
void bind_simulation(py::module_& module);
void bind_tuning(py::module_& module);
void bind_fractional(py::module_& module);
void bind_stability(py::module_& module);

// Copying and comparing by the JSON that describes the object completely.
template <class Object, class Class, class Write, class Read>
void add_value_semantics(Class& cls, const Write& write, const Read& read) {
  cls.def("__eq__", [write](const Object& self, const py::object& other) -> py::object {
    if (!py::isinstance<Object>(other)) {
      return py::reinterpret_borrow<py::object>(Py_NotImplemented);
    }
    return py::bool_(write(self).dump() == write(other.cast<const Object&>()).dump());
  });
  cls.def("__hash__",
          [write](const Object& self) { return std::hash<std::string>()(write(self).dump()); });
  cls.def(py::pickle([write](const Object& self) { return write(self).dump(); },
                     [read](const std::string& text) {
                       Json document;
                       check("pickle", parse_json(text, document));
                       return read(document);
                     }));
  // The objects are immutable but for a controller's memory, which starts afresh in a copy.
  cls.def("__copy__", [write, read](const Object& self) { return read(write(self)); });
  cls.def("__deepcopy__",
          [write, read](const Object& self, const py::dict&) { return read(write(self)); });
}

}  // namespace nfopidn::python
