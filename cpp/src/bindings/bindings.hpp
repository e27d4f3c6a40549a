// The parts of the Python module, each a translation unit.
#pragma once

#include <optional>

#include "convert.hpp"
#include "nfopidn/io/csv.hpp"
#include "nfopidn/parallel/interruption.hpp"
#include "nfopidn/simulation/simulate.hpp"
#include "running_controller.hpp"

namespace nfopidn::python {

// For functions that compute.
using Computes = py::call_guard<StandardArithmetic>;

// A controller's settings, and the law at work once step() is called.
struct PyController {
  ControllerDesign settings;
  RunningController running;

  PyController() = default;
  explicit PyController(const ControllerDesign& given) : settings(given) {}
};

// StandardArithmetic for as long as a context of Python's lasts, for its own arithmetic there.
class ArithmeticContext {
 public:
  void enter() { arithmetic_.emplace(); }
  void leave() { arithmetic_.reset(); }

 private:
  std::optional<StandardArithmetic> arithmetic_;
};

// As a context, ends long work of its thread once a Python function says so: Ctrl-C comes to the
// main thread alone, which sets an event for the others.
class StopIf {
 public:
  explicit StopIf(py::function asked) : asked_(std::move(asked)) {}

  void enter() { outer_ = std::exchange(current_, this); }
  void leave() { current_ = outer_; }

  // Whether a signal's handler raises now, or a StopIf of this thread ends its work, which is
  // KeyboardInterrupt. With the GIL; Python's error is set then.
  static bool raises() {
    if (PyErr_CheckSignals() != 0) return true;
    for (const StopIf* one = current_; one != nullptr; one = one->outer_) {
      const PyObject* const answer = PyObject_CallNoArgs(one->asked_.ptr());
      const bool is_set = answer == Py_True;
      if (answer == nullptr) return true;
      Py_DECREF(answer);
      if (!is_set) continue;
      PyErr_SetNone(PyExc_KeyboardInterrupt);
      return true;
    }
    return false;
  }

 private:
  static inline thread_local StopIf* current_ = nullptr;

  py::function asked_;
  StopIf* outer_ = nullptr;
};

// While one exists, Python's signals are looked at during long work: Ctrl-C ends it. Made and left
// with the GIL, which the work itself does without.
class SignalWatch {
 public:
  SignalWatch() : interruption_([this] { return ask(); }) {}

  // Once the work is done: raises what ended it, KeyboardInterrupt for one.
  void raise_if_interrupted() {
    if (raised_) throw py::error_already_set(std::move(*raised_));
  }

 private:
  bool ask() {
    const py::gil_scoped_acquire acquire;
    if (StopIf::raises()) raised_.emplace();
    return raised_.has_value();
  }

  std::optional<py::error_already_set> raised_;
  Interruption interruption_;
};

// Does work without the GIL; raises what ends it early.
template <class Work>
void watched(const Work& work) {
  const StandardArithmetic arithmetic;
  SignalWatch watch;
  {
    const py::gil_scoped_release release;
    work();
  }
  watch.raise_if_interrupted();
}

// Of a controller that is made for another robot than a run's model, in simulate()'s words.
void warn_of_robot(const ControllerDesign& design, const Robot<double>& robot);

void bind_files(py::module_& module);
void bind_robot(py::module_& module);
void bind_trajectory(py::module_& module);
void bind_tables(py::module_& module);
void bind_scenario(py::module_& module);
void bind_controller(py::module_& module);
void bind_rivals(py::module_& module);
void bind_wheels(py::module_& module);
void bind_simulation(py::module_& module);
void bind_tuning(py::module_& module);
void bind_monte_carlo(py::module_& module);
void bind_measured_runs(py::module_& module);
void bind_fractional(py::module_& module);
void bind_stability(py::module_& module);
void bind_commands(py::module_& module);

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
  // The objects are immutable but for a controller's memory, which is empty in a copy.
  cls.def("__copy__", [write, read](const Object& self) { return read(write(self)); });
  cls.def("__deepcopy__",
          [write, read](const Object& self, const py::dict&) { return read(write(self)); });
}

}  // namespace nfopidn::python
