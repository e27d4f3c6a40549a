// L0. Coefficients of the elementary functions: minimax fits made with mpmath.
#pragma once

#include <stdint.h>  // NOLINT(modernize-deprecated-headers): <cstdint> is not everywhere

#include "nfopidn/foundation/compiler.hpp"

namespace nfopidn {

namespace kernel {

// Truncation errors, relative: sine 3.3e-18 / 3.6e-9, cosine 6.1e-17 / 6.4e-11, small net 5.3e-18,
// exponential fraction 4.8e-18 / 5.3e-10, logarithm 1.1e-18 / 6.9e-10 (double / float).
template <class Base>
struct Coefficients;

template <>
struct Coefficients<double> {
  // sin(r)/r and cos(r) in powers of r^2, |r| <= pi/4.
  static constexpr double sine[] = {0.99999999999999999669,   -0.16666666666666614755,
                                    0.0083333333333200026652, -0.0001984126982840228381,
                                    2.7557313299057388844e-6, -2.5050705851203878509e-8,
                                    1.5894136555061914812e-10};
  static constexpr double cosine[] = {1.0,
                                      -0.49999999999999413893,
                                      0.041666666666487852434,
                                      -0.0013888888870591999691,
                                      0.000024801578649425007947,
                                      -2.7555242416573213756e-7,
                                      2.0630636657875152375e-9};
  // 2^f = (P(f^2) + f Q(f^2)) / (P(f^2) - f Q(f^2)), |f| <= 1/2.
  static constexpr double exponential_q[] = {1513.8603572566878809, 20.201667274710017376,
                                             0.023094408441397100752};
  static constexpr double exponential_p[] = {4368.077660025236169, 233.17769678881258521, 1.0};
  // tanh(n/2) = n P(n^2) / Q(n^2), |n| <= small_net.
  static constexpr double small_net = 0.34375;
  static constexpr double neuron_p[] = {504.15599046914332202, 14.002785345925616808,
                                        0.033317874530310654216};
  static constexpr double neuron_q[] = {1008.3119809382866494, 112.03156910337291897, 1.0};
  // log((1+s)/(1-s))/s in powers of s^2, |s| <= 0.1716.
  static constexpr double logarithm[] = {1.9999999999999999977,  0.66666666666667652,
                                         0.39999999999298885927, 0.2857142876134619701,
                                         0.22222196988277934093, 0.18183635093352953873,
                                         0.15312443766477945721, 0.14810529835259688785};
  // atan(s)/s in powers of s^2, |s| <= tan(pi/8).
  static constexpr double arctangent[] = {
      0.99999999999999999879,   -0.33333333333333129135,  0.1999999999994273719,
      -0.14285714279417233023,  0.11111110752675739241,   -0.09090897019349409225,
      0.076920488866427368626,  -0.066629904374824218024, 0.058471478714156941738,
      -0.050362709720558276709, 0.037993885986781624259,  -0.017835689854521083735};
  // pi/2 in two parts; the first has 33 bits, so that n times it is exact for |n| < 2^20.
  static constexpr double half_pi[] = {1.5707963267341256, 6.07710050650619224932e-11};
  static constexpr double round_magic = 6755399441055744.0;  // 1.5 * 2^52
  using Bits = uint64_t;
  using SignedBits = int64_t;
  static constexpr double epsilon = 2.2204460492503130808e-16;  // 2^-52
  static constexpr int mantissa_bits = 52;
  static constexpr Bits exponent_bias = 1023;
};

template <>
struct Coefficients<float> {
  static constexpr float sine[] = {1.0F, -0.16666655F, 0.0083321777F, -0.00019517235F};
  static constexpr float cosine[] = {1.0F, -0.49999999694480936993F, 0.041666620357434949657F,
                                     -0.0013886681654879084233F, 0.000024383567825801791511F};
  static constexpr float exponential_q[] = {7.2150253886211493751F, 0.057700476756452952788F};
  static constexpr float exponential_p[] = {20.818162707168088868F, 1.0F};
  static constexpr float logarithm[] = {1.9999999986213479826F, 0.66666815950357411398F,
                                        0.39974794942011273262F, 0.29925650692439440629F};
  static constexpr float arctangent[] = {0.99999998199538154833F, -0.33332799192025273744F,
                                         0.19974470311604157645F, -0.13852088276318902232F,
                                         0.079867376412963420527F};
  static constexpr float half_pi[] = {1.5703125F, 4.83826794896619e-4F};
  static constexpr float round_magic = 12582912.0F;  // 1.5 * 2^23
  using Bits = uint32_t;
  using SignedBits = int32_t;
  static constexpr float epsilon = 1.1920928955078125e-7F;  // 2^-23
  static constexpr int mantissa_bits = 23;
  static constexpr Bits exponent_bias = 127;
};

}  // namespace kernel

}  // namespace nfopidn
