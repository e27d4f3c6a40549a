// Prints which instructions are chosen here, and to the last bit where a search ends and the sum of
// its history's means.
#include <cstdio>
#include <cstdlib>

#include "nfopidn/tuning/tune.hpp"

int main(int argc, char** argv) {
  using namespace nfopidn;
  const Scenario scenario = Scenario::published();
  TuningPlan plan = plan_tuning({&scenario}, Structure{});
  plan.search.limits.evaluations = argc > 1 ? std::atol(argv[1]) : 300;
  const SearchResult result = run_tuning(plan);
  std::printf("%s %a", ChoiceNames<InstructionSet>::names[static_cast<int>(best_instruction_set())],
              result.cost);
  for (const double x : result.x) std::printf(" %a", x);
  double means = 0;
  for (const HistoryRow& row : result.history) means += row.mean;
  std::printf(" %a\n", means);
}
