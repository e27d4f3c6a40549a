// A program of somebody else's: host side here, firmware zone in the other translation unit.
#include <cstdio>

#include "nfopidn/simulation/simulate.hpp"

float firmware_torque();
bool firmware_has_every_bit();

int main() {
  const nfopidn::Scenario scenario = nfopidn::Scenario::published();
  const nfopidn::SimulationResult result = nfopidn::simulate(scenario, {});
  std::printf("cost %.9f, firmware torque %.6f N m\n", result.metrics.cost, firmware_torque());
  if (!firmware_has_every_bit()) {
    std::printf("the firmware's last bits differ: is -ffp-contract=off missing from the target?\n");
    return 1;
  }
  const bool right = result.metrics.cost > 0.09205918 && result.metrics.cost < 0.09205919;
  return right && firmware_torque() < 0 ? 0 : 1;
}
