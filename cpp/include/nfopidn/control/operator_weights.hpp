// L1. Weights of the fractional operators' generating functions, and their fusion into taps.
#pragma once

#include "nfopidn/foundation/schema.hpp"
#include "nfopidn/math/math.hpp"

namespace nfopidn {

// The power series that stands for s^order.
enum class Generator : unsigned char {
  tustin,  // ((1 - w)/(1 + w))^order, the paper's
  gl,      // (1 - w)^order, Gruenwald-Letnikov; exact at whole orders
};

template <>
struct ChoiceNames<Generator> {
  static constexpr const char* names[] = {"tustin", "gl"};
};

// Writes c_0 .. c_memory, the power series of ((1 - w)/(1 + pole w))^order: with pole 1 eqs. 16-19,
// the recursion corrected (j f_j = -2 order f_{j-1} + (j - 2) f_{j-2}), with 0 Gruenwald and
// Letnikov's g_j, with 1/7 Al-Alaoui's. From its logarithmic derivative:
//   j c_j = (-(1 + pole) order + (1 - pole)(j - 1)) c_{j-1} + pole (j - 2) c_{j-2}
template <class Base, class Scalar>
constexpr Scalar next_series_weight(Base pole, const Scalar& order, int j, const Scalar& last,
                                    const Scalar& before) {
  const Scalar factor = order * Scalar(-(1 + pole)) + Scalar((1 - pole) * Base(j - 1));
  return (factor * last + before * Scalar(pole * Base(j - 2))) / Scalar(Base(j));
}

template <class Scalar>
constexpr void series_weights(base_t<Scalar> pole, const Scalar& order, int memory,
                              Scalar* weights) {
  using Base = base_t<Scalar>;
  weights[0] = Scalar(Base(1));
  if (memory < 1) return;
  weights[1] = order * Scalar(-(1 + pole));
  for (int j = 2; j <= memory; ++j) {
    weights[j] = next_series_weight(pole, order, j, weights[j - 1], weights[j - 2]);
  }
}

template <class Base>
constexpr Base pole_of(Generator generator) {
  return generator == Generator::tustin ? Base(1) : Base(0);
}

template <class Scalar>
constexpr void generator_weights(Generator generator, const Scalar& order, int memory,
                                 Scalar* weights) {
  series_weights(pole_of<base_t<Scalar>>(generator), order, memory, weights);
}

// The three sums of eq. 34 as one filter: writes the memory + 2 taps of
//   net(k) = kp (e_k - e_{k-1}) + kd sum f_j(alpha) (e_{k-j} - e_{k-j-1})
//          + ki sum f_j(1 - sigma) (e_{k-j} + e_{k-j-1}),      j = 0 .. memory
// With the generator gl the last sum runs over g_j(1 - sigma) e_{k-j} alone, which at orders
// (1, 1) makes net the increment of the textbook PID.
// `work` is memory + 1 scalars of scratch.
template <class Scalar>
constexpr void fuse_taps(Generator generator, const Scalar& kp, const Scalar& ki, const Scalar& kd,
                         const Scalar& alpha, const Scalar& sigma, int memory, Scalar* taps,
                         Scalar* work) {
  for (int j = 0; j < memory + 2; ++j) taps[j] = Scalar(0);
  taps[0] += kp;
  taps[1] -= kp;
  generator_weights(generator, alpha, memory, work);
  for (int j = 0; j <= memory; ++j) {
    taps[j] += kd * work[j];
    taps[j + 1] -= kd * work[j];
  }
  generator_weights(generator, Scalar(1) - sigma, memory, work);
  for (int j = 0; j <= memory; ++j) {
    taps[j] += ki * work[j];
    if (generator == Generator::tustin) taps[j + 1] += ki * work[j];
  }
}

// The same sums over the error itself, not its differences:
//   net(k) = kp e_k + kd sum f_j(alpha) e_{k-j} + ki sum f_j(-sigma) e_{k-j},  j = 0 .. memory + 1
// `work` is memory + 2 scalars of scratch.
template <class Scalar>
constexpr void fuse_whole_taps(Generator generator, const Scalar& kp, const Scalar& ki,
                               const Scalar& kd, const Scalar& alpha, const Scalar& sigma,
                               int memory, Scalar* taps, Scalar* work) {
  using Base = base_t<Scalar>;
  generator_weights(generator, alpha, memory + 1, work);
  for (int j = 0; j < memory + 2; ++j) taps[j] = kd * work[j];
  generator_weights(generator, sigma * Base(-1), memory + 1, work);
  for (int j = 0; j < memory + 2; ++j) taps[j] += ki * work[j];
  taps[0] += kp;
}

// The derivative of order alpha of the error as that of order alpha - 1 of the speed error n:
//   sum g_j(alpha - 1) n_{k-j},  j = 0 .. memory + 1
template <class Scalar>
constexpr void fuse_speed_taps(const Scalar& gain, const Scalar& order, int memory, Scalar* taps) {
  generator_weights(Generator::gl, order - Scalar(base_t<Scalar>(1)), memory + 1, taps);
  for (int j = 0; j < memory + 2; ++j) taps[j] = gain * taps[j];
}

}  // namespace nfopidn
