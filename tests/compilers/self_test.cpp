// Prints the verdicts for float and double, and the torques at a heading error of 0.5 rad.
#include <cstdio>

#include "nfopidn/firmware.hpp"

template <class Scalar>
void print() {
  using namespace nfopidn;
  volatile Scalar heading = Scalar(-0.5);
  Controller<Scalar, Fir<Scalar, 7>> law;
  law.configure({});
  const auto torque = law.step({0, 0, heading, 0, 0}, {});
  std::printf("%d %.3f %.3f ", static_cast<int>(self_test<Scalar>()),
              static_cast<double>(torque.left), static_cast<double>(torque.right));
}

int main() {
  print<float>();
  print<double>();
  std::printf("\n");
}
