// The second translation unit: the same headers again, in float.
#include "nfopidn/firmware.hpp"

bool firmware_has_every_bit() { return nfopidn::self_test<float>() == nfopidn::SelfTest::ok; }

float firmware_torque() {
  nfopidn::Controller<float, nfopidn::Fir<float, 7>> controller;
  controller.configure({});
  nfopidn::ReferenceSample<float> reference = {};
  reference.x = 3;
  return controller.step({4, 0, 1.0472F, 0, 0}, reference).left;
}
