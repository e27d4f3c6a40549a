// A program as a board has it: the firmware zone alone.
#include <cstdio>

float firmware_torque();
bool firmware_has_every_bit();

int main() {
  std::printf("firmware torque %.6f N m\n", static_cast<double>(firmware_torque()));
  return firmware_has_every_bit() && firmware_torque() < 0 ? 0 : 1;
}
