// The executable nfopidn_sim.
#include "command.hpp"

int main(int argc, char** argv) {
  return nfopidn::commands::run_simulate("nfopidn_sim", {argv + (argc > 0 ? 1 : 0), argv + argc});
}
