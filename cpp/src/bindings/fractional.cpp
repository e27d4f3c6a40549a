// Fractional operators. The arguments are checked in Python, where the errors are raised.
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "nfopidn/analysis/conversion.hpp"
#include "nfopidn/analysis/rational.hpp"

namespace nfopidn::python {

namespace {

using Samples = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Row = py::array_t<double>;

// The filter and what it was made of.
struct PyFractionalFilter {
  FractionalFilter filter;
  double certificate = -1;  // negative: not yet computed
};

int samples_of(double memory) {
  return std::isinf(memory) ? infinite_memory : static_cast<int>(memory);
}

Row weights(double pole, double order, int memory) {
  Row result(memory + 1);
  series_weights(pole, order, memory, result.mutable_data());
  return result;
}

Row process(PyFractionalFilter& self, const Samples& samples) {
  Row result(samples.size());
  const double* in = samples.data();
  double* out = result.mutable_data();
  const py::ssize_t count = samples.size();
  // Not without the GIL: another thread's step would meet a filter between two states.
  constexpr py::ssize_t seldom = 1 << 16;
  std::optional<FractionalFilter> before;
  if (count > seldom) before = self.filter;
  for (py::ssize_t first = 0; first < count; first += seldom) {
    if (first > 0 && StopIf::raises()) {
      self.filter = *before;
      throw py::error_already_set();
    }
    self.filter.process(in + first, out + first, std::min(seldom, count - first));
  }
  return result;
}

double certificate(PyFractionalFilter& self) {
  if (self.certificate < 0) {
    const StandardArithmetic arithmetic;
    const py::gil_scoped_release release;
    self.certificate = self.filter.certificate();
  }
  return self.certificate;
}

py::tuple to_tuple(const ZerosPoles& model) {
  return py::make_tuple(model.zeros, model.poles, model.gain);
}

}  // namespace

void bind_fractional(py::module_& module) {
  module.def("series_weights", &weights, Computes(), py::arg("pole"), py::arg("order"),
             py::arg("memory"),
             "series_weights(pole, order, memory)\n--\n\nThe power series of ((1 - w)/(1 + pole "
             "w))^order, (memory + 1,).");
  module.def(
      "rule_scale",
      [](double pole, double dt, double prewarp) {
        return DifferenceRule{pole, dt, prewarp}.scale();
      },
      Computes(), py::arg("pole"), py::arg("dt"), py::arg("prewarp"),
      "rule_scale(pole, dt, prewarp)\n--\n\nThe rule's scale [1/s].");
  module.def(
      "continued_fraction",
      [](double order, double pole, double dt, double prewarp, int sections) {
        return to_tuple(continued_fraction(order, {pole, dt, prewarp}, sections));
      },
      Computes(), py::arg("order"), py::arg("pole"), py::arg("dt"), py::arg("prewarp"),
      py::arg("sections"),
      "continued_fraction(order, pole, dt, prewarp, sections)\n--\n\nZeros, poles, gain.");
  module.def(
      "oustaloup",
      [](double order, double dt, double prewarp, int sections, double low, double high) {
        return to_tuple(oustaloup(order, {1, dt, prewarp}, sections, low, high));
      },
      Computes(), py::arg("order"), py::arg("dt"), py::arg("prewarp"), py::arg("sections"),
      py::arg("low"), py::arg("high"),
      "oustaloup(order, dt, prewarp, sections, low, high)\n--\n\nZeros, poles, gain.");
  module.def(
      "gain_factors",
      [](const std::string& generator, double alpha, double sigma, double dt, double prewarp) {
        return gain_factors(generator == "gl" ? Generator::gl : Generator::tustin, alpha, sigma, dt,
                            prewarp);
      },
      Computes(), py::arg("generator"), py::arg("alpha"), py::arg("sigma"), py::arg("dt"),
      py::arg("prewarp"),
      "gain_factors(generator, alpha, sigma, dt, prewarp)\n--\n\nDiscrete kp, ki, kd over "
      "continuous ones (eq. 25).");
  using F = PyFractionalFilter;
  py::class_<F>(module, "SampleFilter", py::is_final(),
                "SampleFilter(order, pole, dt, prewarp, memory, horizon)\n--\n\nWhat "
                "nfopidn.fractional.FractionalFilter runs.")
      .def(py::init([](double order, double pole, double dt, double prewarp, double memory,
                       int horizon) {
             return F{FractionalFilter(order, {pole, dt, prewarp}, samples_of(memory), horizon)};
           }),
           Computes(), py::arg("order"), py::arg("pole"), py::arg("dt"), py::arg("prewarp"),
           py::arg("memory"), py::arg("horizon"))
      .def(
          "copy", [](const F& self) { return F(self); },
          "copy(self)\n--\n\nOne that goes on from the same state.")
      .def(
          "step", [](F& self, double sample) { return self.filter.step(sample); }, Computes(),
          py::arg("sample"), "step(self, sample)\n--\n\nThe next output.")
      .def("process", &process, Computes(), py::arg("samples"),
           "process(self, samples)\n--\n\nThe next outputs.")
      .def(
          "reset", [](F& self) { self.filter.reset(); }, "reset(self)\n--\n\nForgets all samples.")
      .def_property_readonly("rest", [](const F& self) { return self.filter.order().rest; })
      .def_property_readonly("gain", [](const F& self) { return self.filter.gain(); })
      .def_property_readonly("modes",
                             [](const F& self) { return self.filter.kernel().mode_count(); })
      .def_property_readonly("certificate", &certificate);
}

}  // namespace nfopidn::python
