// What stands between the law and a robot's wheels: their sign, and odometry.
#include <array>

#include "bindings.hpp"
#include "nfopidn/firmware/odometry.hpp"

namespace nfopidn::python {

namespace {

using Numbers3 = std::array<double, 3>;

py::tuple swapped(const py::object& pair) {
  const Numbers numbers = real_numbers("to_rep103", "torque", pair);
  if (numbers.ndim() != 1 || numbers.size() != 2) {
    throw py::value_error("to_rep103: torque must be two numbers: left, right");
  }
  const TorquePair<double> real = to_rep103(TorquePair<double>{numbers.at(0), numbers.at(1)});
  return py::make_tuple(real.left, real.right);
}

py::tuple moved(const py::object& pose, double left, double right, double track_width) {
  const Numbers numbers = real_numbers("odometry", "pose", pose);
  if (numbers.ndim() != 1 || numbers.size() != 3) {
    throw py::value_error("odometry: pose must be three numbers: x, y, theta");
  }
  const Numbers3 ways = {left, right, track_width};
  const char* const names[] = {"left", "right", "track_width"};
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const Range range = i == 2 ? greater_than(0) : any_number();
    if (std::isfinite(ways[i]) && range.contains(ways[i])) continue;
    raise("odometry", refuse_number(names[i], ways[i], range, "m"));
  }
  for (py::ssize_t i = 0; i < 3; ++i) {
    if (std::isfinite(numbers.at(i))) continue;
    raise("odometry",
          refuse_number("pose[" + std::to_string(i) + "]", numbers.at(i), any_number()));
  }
  const State<double> next = odometry(
      State<double>{numbers.at(0), numbers.at(1), numbers.at(2), 0, 0}, left, right, track_width);
  return py::make_tuple(next.x, next.y, next.theta);
}

}  // namespace

void bind_wheels(py::module_& module) {
  module.def("to_rep103", &swapped, py::arg("torque"),
             "to_rep103(torque)\n--\n\nThe pair (left, right) of a real robot's wheels by REP-103, "
             "whose right wheel turns it counter-clockwise:\nthe paper's left wheel does, so that "
             "the two change places. For torques and wheel speeds, in both\ndirections.");
  module.def(
      "odometry", &moved, Computes(), py::arg("pose"), py::arg("left"), py::arg("right"),
      py::arg("track_width"),
      "odometry(pose, left, right, track_width)\n--\n\nThe pose (x, y [m], theta [rad] in "
      "[-pi, pi]) after the wheels of REP-103 have rolled left and right\nmetres on an arc "
      "of a circle, exactly, however long. track_width [m]. ValueError: what is not finite.");
}

}  // namespace nfopidn::python
