// What Controller and Rival share where they are stepped from Python.
#pragma once

#include "bindings.hpp"
#include "nfopidn/rivals/rivals.hpp"

namespace nfopidn::python {

// A rival's settings, and the law at work once start() is called.
struct PyRival {
  rivals::RivalDesign design;
  std::unique_ptr<rivals::AnyRival> running;
  double torque_limit = 0;  // [N m], that of the law at work

  PyRival() = default;
  explicit PyRival(rivals::RivalDesign given) : design(std::move(given)) {}
};

struct StepArguments {
  Measurement<double> measured;
  ReferenceSample<double> reference;
};

// Refuses other shapes and numbers that are not finite.
inline StepArguments step_arguments(const std::string& callable, const py::object& measured_numbers,
                                    const py::object& reference_numbers) {
  const Numbers measurement = real_numbers(callable, "measurement", measured_numbers);
  const Numbers reference = real_numbers(callable, "reference", reference_numbers);
  if (measurement.ndim() != 1 || measurement.size() < 3 || measurement.size() > 5) {
    throw py::value_error(callable + ": measurement has " + std::to_string(measurement.size()) +
                          " numbers; must have 3 to 5: x, y, theta, v, omega");
  }
  if (reference.ndim() != 1 || reference.size() != 8) {
    throw py::value_error(callable + ": reference has " + std::to_string(reference.size()) +
                          " numbers; must have 8: x, y, theta, v, omega, tau_left, tau_right, "
                          "reverse");
  }
  for (const auto& [array, name] :
       {std::pair{&measurement, "measurement"}, std::pair{&reference, "reference"}}) {
    for (py::ssize_t i = 0; i < array->size(); ++i) {
      // Beyond, a float's digits no longer tell one centimetre from the next.
      const Range range = between(-1e12, 1e12);
      const double number = array->at(i);
      if (range.contains(number)) continue;
      raise(callable, refuse_number(std::string(name) + "[" + std::to_string(i) + "]", number,
                                    std::isfinite(number) ? range : any_number()));
    }
  }
  const auto measured = [&](py::ssize_t i) {
    return i < measurement.size() ? measurement.at(i) : 0;
  };
  const auto wanted = [&](py::ssize_t i) { return reference.at(i); };
  return {{measured(0), measured(1), measured(2), measured(3), measured(4)},
          {wanted(0), wanted(1), wanted(2), wanted(3), wanted(4), wanted(5), wanted(6),
           wanted(7) != 0}};
}

// The limit [N m] that a step is given, or the one of before.
inline double step_limit(const std::string& callable, const py::object& given, double before) {
  if (given.is_none()) return before;
  double limit = 0;
  try {
    limit = given.cast<double>();
  } catch (const py::cast_error&) {
    throw py::type_error(callable + ": torque_limit must be a number [N m] or None, not " +
                         py::str(py::type::of(given)).cast<std::string>());
  }
  const Range positive = greater_than(0);
  if (!std::isfinite(limit) || !positive.contains(limit)) {
    raise(callable, refuse_number("torque_limit", limit, positive, "N m"));
  }
  return limit;
}

// Says that the gains are made for another robot.
inline void warn_of_robot(const std::string& callable, const ControllerDesign& design,
                          const Robot<double>& robot) {
  const std::string text = explain_robot(design, robot);
  if (text.empty()) return;
  if (PyErr_WarnEx(PyExc_UserWarning, (callable + ": " + text).c_str(), 1) != 0) {
    throw py::error_already_set();
  }
}

// What a run of the scenario tells its controller.
inline ControlLimits<double> limits_of(const Scenario& scenario) {
  const Trajectory& path = scenario.trajectory;
  return {scenario.torque_limit, std::max(path.peak_speed(), least_speed_scale), path.dt()};
}

}  // namespace nfopidn::python
