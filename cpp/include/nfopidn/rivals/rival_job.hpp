// L4. What the units per instruction set are given of rivals: raw pointers, borrowed.
#pragma once

#include "nfopidn/rivals/rival.hpp"
#include "nfopidn/tuning/batch_job.hpp"

namespace nfopidn {

// The laws that run in lanes.
enum class LaneLaw : unsigned char { samson, lqr, takagi_sugeno, sliding_mode };

template <>
struct ChoiceNames<LaneLaw> {
  static constexpr const char* names[] = {"samson", "lqr", "takagi-sugeno", "sliding-mode"};
};

constexpr int most_rival_numbers = 16;   // of a law's settings and its integral action
constexpr int most_table_entries = 256;  // of the regulator's gains

struct RivalJob {
  const RobotDrive<double>* plant;
  const LoopInputs<double>* inputs;  // for costs with headings; with noise, of zeros if need be
  const State<double>* start;
  rivals::Model<double> model;
  double torque_limit;
  rivals::Speeds speeds;
  LaneLaw law;
  // [candidates][number_count]: the settings of the law, IntegralGains, and the regulator's table,
  // [table_size] of LqrGains; of its settings those of the velocity loop alone.
  const double* numbers;
  int number_count;
  int table_size;
  double table_spacing;  // [m/s]
  int candidates;
  double* costs;         // [candidates]
  const double* bounds;  // [candidates], or null, as in BatchJob
  Poll poll;
};

// One candidate and the slopes of its numbers in several directions.
struct RivalGradientJob {
  RivalJob batch;
  const double* slopes;  // [directions][number_count]
  int directions;
  double* gradient;  // [directions]
};

}  // namespace nfopidn
