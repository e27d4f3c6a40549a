// L2. What the units per instruction set are given: raw pointers, borrowed.
#pragma once

#include "nfopidn/loop.hpp"

namespace nfopidn {

constexpr int batch_capacity = 34;  // most taps a channel: memory 32

struct BatchJob {
  const Plant<double>* plant;
  const LoopInputs<double>* inputs;  // for costs with headings, for gradients without
  const State<double>* start;
  const ControllerSettings<double>* structure;
  const ControlLimits<double>* limits;
  const double* taps;  // [candidates][3][tap_count]
  int tap_count;
  int candidates;
  double* costs;         // [candidates]
  const double* bounds;  // [candidates], or null: whoever costs more is given some cost over it
};

// One candidate and the slopes of its taps in several directions.
struct GradientJob {
  BatchJob batch;        // its taps are those of the one candidate, costs its cost
  const double* slopes;  // [directions][3][tap_count]
  int directions;
  double* gradient;  // [directions]: the cost's slopes
};

}  // namespace nfopidn
