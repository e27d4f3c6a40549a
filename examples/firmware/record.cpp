// Host program: makes the recording that the firmware runs, and the torques to compare with.
//   record DIRECTORY   writes recording.hpp, and torques.csv with a row a sample:
//                      the float step's bit patterns here, the double step's torques for the same
//                      inputs, and those of the recorded run itself (the stress samples have none)
#include <cinttypes>
#include <cstdio>
#include <string>
#include <vector>

#include "nfopidn/simulation/simulate.hpp"
#include "sample.hpp"
#include "settings.hpp"

namespace {

using namespace nfopidn;
using Recording = std::vector<Sample>;
using Pairs = std::vector<TorquePair<double>>;
using DoubleLaw = Controller<double, Fir<double, 7>, TrackingVariant<double>>;

struct Run {
  Recording samples;
  Pairs torques;
};

Run published_run() {
  const Scenario scenario = Scenario::published();
  const PreparedRun run = prepare(scenario);
  Run result;
  DoubleLaw law;
  law.configure(control_settings<double>(), run.limits);
  const auto f = [](double value) { return static_cast<float>(value); };
  run_closed_loop<double>(
      run.plant, law, run.start, run.inputs(),
      [&](int k, const State<double>& s, const TorquePair<double>& torque, const auto&) {
        const ReferenceSample<double>& r = run.reference[static_cast<std::size_t>(k)];
        result.samples.push_back({{f(s.x), f(s.y), f(s.theta), f(s.v), f(s.omega)},
                                  {f(r.x), f(r.y), f(r.theta), f(r.v), f(r.omega), f(r.tau_left),
                                   f(r.tau_right), r.reverse}});
        result.torques.push_back(torque);
      });
  return result;
}

// Errors of all sizes, headings far out and torques beyond the limit: every branch of the step.
Recording stress_samples() {
  Recording samples;
  Random random(1);
  const auto draw = [&](double size) {
    return static_cast<float>(size * (2 * random.uniform() - 1));
  };
  for (int k = 0; k < 600; ++k) {
    const double size = k % 3 == 0 ? 0.05 : k % 3 == 1 ? 1 : 20;
    samples.push_back({{draw(size), draw(size), draw(4 * size), 0, 0},
                       {draw(size), draw(size), draw(4 * size), draw(1), draw(1), draw(size),
                        draw(size), draw(1) < 0}});
  }
  return samples;
}

void write_samples(std::FILE* file, const char* name, const Recording& samples) {
  std::fprintf(file, "inline constexpr Sample %s[] = {\n", name);
  for (const Sample& s : samples) {
    const Pose& m = s.measured;
    const Reference& r = s.reference;
    std::fprintf(file, "    {{%aF, %aF, %aF, %aF, %aF},\n", m.x, m.y, m.theta, m.v, m.omega);
    std::fprintf(file, "     {%aF, %aF, %aF, %aF, %aF, %aF, %aF, %s}},\n", r.x, r.y, r.theta, r.v,
                 r.omega, r.tau_left, r.tau_right, r.reverse ? "true" : "false");
  }
  std::fprintf(file, "};\n");
}

void write_torques(std::FILE* file, const char* name, const Recording& samples, const Pairs& run) {
  control_reset();
  DoubleLaw law;
  law.configure(control_settings<double>());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Pose& m = samples[k].measured;
    const Reference& r = samples[k].reference;
    const Torques single = control_step(m, r);
    const TorquePair<double> same =
        law.step({m.x, m.y, m.theta, m.v, m.omega},
                 {r.x, r.y, r.theta, r.v, r.omega, r.tau_left, r.tau_right, r.reverse});
    const TorquePair<double> recorded = run.empty() ? same : run[k];
    std::fprintf(file, "%s,%08" PRIx32 ",%08" PRIx32 ",%.17g,%.17g,%.17g,%.17g\n", name,
                 __builtin_bit_cast(std::uint32_t, single.left),
                 __builtin_bit_cast(std::uint32_t, single.right), same.left, same.right,
                 recorded.left, recorded.right);
  }
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: record DIRECTORY\n");
    return 2;
  }
  const std::string directory = words[1];
  const Run run = published_run();
  const Recording stress = stress_samples();

  std::FILE* header = std::fopen((directory + "/recording.hpp").c_str(), "w");
  std::FILE* table = std::fopen((directory + "/torques.csv").c_str(), "w");
  if (header == nullptr || table == nullptr) {
    std::fprintf(stderr, "record: cannot write into %s\n", directory.c_str());
    return 1;
  }
  std::fprintf(header, "// Made by record. Do not edit.\n#pragma once\n#include \"sample.hpp\"\n");
  write_samples(header, "recorded", run.samples);
  write_samples(header, "stress", stress);
  std::fprintf(table, "run,left,right,same_left,same_right,run_left,run_right\n");
  write_torques(table, "recorded", run.samples, run.torques);
  write_torques(table, "stress", stress, {});
  return std::fclose(header) != 0 || std::fclose(table) != 0 ? 1 : 0;
}
