// L3. The loops of wide.hpp, which includes this once for each instruction set: no include guard.
// NFOPIDN_WIDE_SET names it, NFOPIDN_WIDE_NUMBERS tells how many doubles it takes at once.

namespace nfopidn::wide::NFOPIDN_WIDE_SET {

constexpr long numbers = NFOPIDN_WIDE_NUMBERS;
constexpr long parts = 8 / numbers;
using Part = double __attribute__((vector_size(8 * NFOPIDN_WIDE_NUMBERS)));

inline __attribute__((always_inline)) Part load(const double* from) {
  Part part;
  __builtin_memcpy(&part, from, sizeof part);
  return part;
}

// Eight sums side by side as one, in the same order for every width.
inline __attribute__((always_inline)) double sum(const Part* eight) {
  double v[8];
  __builtin_memcpy(v, eight, sizeof v);
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

// Two rows of sums take turns: an addition need not wait for the last.
inline double dot(const double* a, const double* b, long count) {
  Part even[parts] = {}, odd[parts] = {};
  long i = 0;
  for (; i + 8 < count; i += 16) {
    for (long n = 0; n < parts; ++n) {
      even[n] += load(a + i + n * numbers) * load(b + i + n * numbers);
      odd[n] += load(a + i + 8 + n * numbers) * load(b + i + 8 + n * numbers);
    }
  }
  if (i < count) {
    for (long n = 0; n < parts; ++n) {
      even[n] += load(a + i + n * numbers) * load(b + i + n * numbers);
    }
  }
  for (long n = 0; n < parts; ++n) even[n] += odd[n];
  return sum(even);
}

// As x - decay x + ...: the slowest 1 - decay could not be told from 1.
inline double advance(Modes* const modes, long count, long ending, double coming, double leaving) {
  Part total[parts] = {};
  const auto move = [&](Modes& block, long n, const Part& input) {
    double* const state = block.state + n * numbers;
    const Part before = load(state);
    const Part now = (input - load(block.decay + n * numbers) * before) + before;
    __builtin_memcpy(state, &now, sizeof now);
    total[n] += now;
  };
  for (long i = 0; i < ending; ++i) {
    for (long n = 0; n < parts; ++n) {
      const long at = n * numbers;
      move(modes[i], n, load(modes[i].residue + at) * coming - load(modes[i].end + at) * leaving);
    }
  }
  for (long i = ending; i < count; ++i) {
    for (long n = 0; n < parts; ++n)
      move(modes[i], n, load(modes[i].residue + n * numbers) * coming);
  }
  return sum(total);
}

}  // namespace nfopidn::wide::NFOPIDN_WIDE_SET
