// Prints which instructions are chosen here, and some costs and slopes to the last bit.
#include <cstdio>

#include "nfopidn/tune.hpp"

int main() {
  using namespace nfopidn;
  const Scenario scenario = Scenario::published();
  TuningTask task;
  task.scenarios = {&scenario};
  task.evaluations = 300;
  const SearchResult result = run_tuning(task);
  std::printf("%s %a", ChoiceNames<InstructionSet>::names[static_cast<int>(best_instruction_set())],
              result.cost);
  for (const double x : result.x) std::printf(" %a", x);
  std::printf("\n");
}
