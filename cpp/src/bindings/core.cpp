// The Python module nfopidn._core.
#include "bindings.hpp"

PYBIND11_MODULE(_core, module) {
  namespace binding = nfopidn::python;
  module.doc() = "The C++ core of nfopidn. Import nfopidn instead.";
  module.attr("__version__") = NFOPIDN_VERSION;
  binding::py::options options;
  options.disable_function_signatures();
  binding::py::class_<binding::StopIf>(
      module, "StopIf", binding::py::is_final(),
      "StopIf(asked)\n--\n\nAs a context, ends long work of its thread with KeyboardInterrupt once "
      "asked() is True.")
      .def(binding::py::init<binding::py::function>(), binding::py::arg("asked"))
      .def("__enter__", &binding::StopIf::enter)
      .def("__exit__",
           [](binding::StopIf& self, const binding::py::args& /*error*/) { self.leave(); });
  binding::py::class_<binding::ArithmeticContext>(
      module, "StandardArithmetic", binding::py::is_final(),
      "StandardArithmetic()\n--\n\nAs a context, rounds to nearest and keeps subnormal numbers in "
      "its thread, whatever another library has left on, which comes back at the end.")
      .def(binding::py::init<>())
      .def("__enter__", &binding::ArithmeticContext::enter)
      .def("__exit__", [](binding::ArithmeticContext& self, const binding::py::args& /*error*/) {
        self.leave();
      });
  binding::bind_files(module);
  binding::bind_robot(module);
  binding::bind_trajectory(module);
  binding::bind_tables(module);
  binding::bind_scenario(module);
  binding::bind_controller(module);
  binding::bind_rivals(module);
  binding::bind_wheels(module);
  binding::bind_simulation(module);
  binding::bind_tuning(module);
  binding::bind_monte_carlo(module);
  binding::bind_measured_runs(module);
  binding::bind_fractional(module);
  binding::bind_stability(module);
  binding::bind_commands(module);
}
