// What to do when a sample has no measurement: the published scenario's cost (eq. 41) when random
// samples are lost, bridged in three ways. 200 seeds each. The figures of docs/embedding.md.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <vector>

#include "nfopidn/firmware/guarded.hpp"
#include "nfopidn/math/random.hpp"
#include "nfopidn/simulation/simulate.hpp"
#include "nfopidn/tuning/structures.hpp"

namespace {

using namespace nfopidn;

enum Way { hold, feedforward, repeat };
constexpr const char* names[] = {"last torque held, law at rest",
                                 "last feedback, present feedforward",
                                 "law on its last error (missed())"};
constexpr int runs = 200;

// Loses a share of its samples, but never the first.
template <class Law>
class Lossy {
 public:
  Lossy(Law& law, double share, Way way, int seed, double limit)
      : law_(law),
        guarded_(law, std::numeric_limits<int>::max()),
        share_(share),
        way_(way),
        limit_(limit),
        random_(static_cast<std::uint64_t>(seed)) {}

  TorquePair<double> step(const Measurement<double>& measured,
                          const ReferenceSample<double>& reference) {
    const bool lost = random_.uniform() < share_ && begun_;
    begun_ = true;
    if (!lost) return guarded_.step(measured, reference);
    if (way_ == repeat) return guarded_.missed(reference);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    if (way_ == hold) return guarded_.step({nan, nan, nan, nan, nan}, reference);
    const TorquePair<double> last = law_.feedback();
    return {std::clamp(last.left + reference.tau_left, -limit_, limit_),
            std::clamp(last.right + reference.tau_right, -limit_, limit_)};
  }

 private:
  Law& law_;
  Guarded<Law, double> guarded_;
  double share_;
  Way way_;
  double limit_;
  Random random_;
  bool begun_ = false;
};

void report(const PreparedRun& run, const ControllerDesign& design, double share, Way way) {
  std::vector<double> costs;
  int diverged = 0;
  for (int seed = 1; seed <= runs; ++seed) {
    with_tap_controller(design, run.limits, [&](auto& law) {
      law.reset();
      Lossy lossy(law, share, way, seed, run.limits.torque);
      const auto result =
          run_closed_loop<double>(run.plant, lossy, run.start, run.inputs(), [](int, auto&&...) {});
      costs.push_back(result.cost);
      if (result.completed < run.inputs().samples) ++diverged;
      return 0;
    });
  }
  std::sort(costs.begin(), costs.end());
  std::printf("%6.0f %%  %-36s %10.5f %10.5f %10.5f %6d\n", 100 * share, names[way],
              costs[runs / 2], costs[runs * 9 / 10], costs.back(), diverged);
}

}  // namespace

int main() {
  const Scenario scenario = Scenario::published();
  const PreparedRun run = prepare(scenario);
  for (const bool tuned : {false, true}) {
    const ControllerDesign design = tuned ? tuned_nominal() : ControllerDesign{};
    std::printf("%s gains, E = %.5f without a loss\n", tuned ? "tuned" : "published",
                evaluate(run, design));
    std::printf("%8s  %-36s %10s %10s %10s %6s\n", "lost", "", "median", "90 %", "worst", "div.");
    for (const double share : {0.05, 0.2}) {
      for (const Way way : {hold, feedforward, repeat}) report(run, design, share, way);
    }
  }
}
