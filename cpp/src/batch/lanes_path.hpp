// The path of lanes under constant accelerations, or under speeds that relax.
//
// Without viscous friction v and omega are linear in time, so that the pose is a Fresnel integral.
// With h half of the time and s = -1 .. 1 across it, the heading is that of the middle plus
// p s + q s^2; a power series in p^2 and q^2 gives the path while both are small, as they are on
// nearly every step of a run that tracks. A lane that turns further is moved in equal parts, as
// many as it needs; with viscous friction every lane is, by the quadrature of
// plant/exponential_motion.hpp on panels. The number of parts is each lane's own, so that no result
// depends on the neighbours.
#pragma once

#include "lanes_math.hpp"
#include "nfopidn/plant/exponential_motion.hpp"

namespace nfopidn {

namespace lanes {

// Where a motion ends, seen from where it starts: the way along the first heading, the way across
// it [m], and the angle turned [rad].
template <class V>
struct Displacement {
  V along, across, turned;
};

template <class V, int terms>
NFOPIDN_INLINE V horner(const V& x, const double (&coefficients)[terms]) {
  V sum = x * coefficients[terms - 1] + coefficients[terms - 2];
  for (int i = terms - 3; i >= 0; --i) sum = sum * x + coefficients[i];
  return sum;
}

// The integrals from 0 to 1 of cos(p s) e^{i q s^2} and of s sin(p s) e^{i q s^2} ds, real and
// imaginary parts. Fitted for |p| <= most_turn and |q| <= most_bend: Chebyshev series in p^2 and
// q^2, absolute errors under 4e-14.
constexpr double most_turn = 0.25;
constexpr double most_bend = 0.0625;
template <class V>
struct Fresnel {
  V cosine, cosine_bent, sine, sine_bent;

  NFOPIDN_INLINE Fresnel(const V& p, const V& q) {
    constexpr double c0[] = {0.99999999999999698776, -0.1666666666664134934,
                             0.0083333333187832197413, -0.00019841224469588505859,
                             2.749960165639440248e-6};
    constexpr double c2[] = {-0.099999999987376428964, 0.035714285225764014176,
                             -0.0023148087232493838412, 0.000062997136293443827636};
    constexpr double c4[] = {0.0046296211254235518262, -0.001893659681181857755,
                             0.00013316584488555796933};
    constexpr double c6 = -0.00010538458792033550202;
    constexpr double c1[] = {0.33333333333275398399, -0.099999999783532720409,
                             0.0059523666574917995158, -0.00015400467744729384925};
    constexpr double c3[] = {-0.023809523516352310504, 0.0092592145076822197861,
                             -0.0006295555090603936517};
    constexpr double c5[] = {0.00075748698086774074022, -0.00031903451963894529301};
    constexpr double s0[] = {0.33333333333328118825, -0.033333333315277223851,
                             0.0011904749241850118767, -0.000022014560480323146425};
    constexpr double s2[] = {-0.07142857138082447362, 0.0092592534932170024966,
                             -0.00037869701706031137005, 7.6178870111043074558e-6};
    constexpr double s4[] = {0.0037878649926893727142, -0.00053266349806615947522};
    constexpr double s6 = -0.000092157816933818420335;
    constexpr double s1[] = {0.19999999999991642698, -0.02380952378666438625,
                             0.00092592448104325143692, -0.000018006740213211085002};
    constexpr double s3[] = {-0.018518518393777333853, 0.0025252466768188845347,
                             -0.00010661518758926420117};
    constexpr double s5[] = {0.0006409552667287833197, -0.000092327431897322048792};
    const V x = p * p;
    const V y = q * q;
    cosine = ((y * c6 + horner(x, c4)) * y + horner(x, c2)) * y + horner(x, c0);
    cosine_bent = ((horner(x, c5) * y + horner(x, c3)) * y + horner(x, c1)) * q;
    sine = (((y * s6 + horner(x, s4)) * y + horner(x, s2)) * y + horner(x, s0)) * p;
    sine_bent = ((horner(x, s5) * y + horner(x, s3)) * y + horner(x, s1)) * (p * q);
  }
};

template <class V>
using Motion = exact::ExponentialMotion<V, double>;

template <class V>
struct Travel {
  using M = math<V>;

  // By quadrature, whatever the angles. No time is longer than `longest`.
  NFOPIDN_NOINLINE static Displacement<V> by_quadrature(const Motion<V>& motion, const V& time,
                                                        double longest) {
    using Rule = exact::Quadrature<double>;
    const int slow = exact::halvings(motion.rate * longest);
    const int slow_turn = exact::halvings(motion.turn_rate * longest);
    const auto linear = [&](const V& t) { return exact::decay(motion.rate, t, slow); };
    const auto angular = [&](const V& t) { return exact::decay(motion.turn_rate, t, slow_turn); };
    const exact::Decay<V> all = angular(time);
    const V last_omega = motion.omega + motion.turn_acceleration * all.phi;
    const double rate = motion.rate > motion.turn_rate ? motion.rate : motion.turn_rate;
    const V turned = (magnitude(motion.omega) + magnitude(last_omega)) * time;
    const V wanted = M::maximum(turned, time * rate) * 0.5;
    const V panels = M::minimum(M::maximum(M::nearest(wanted + 0.5), V(1.0)), V(exact::max_panels));
    const V half = time * 0.5 / panels;
    V along(0.0), across(0.0);
    V panel(0.0);
    for (int i = 0; i < exact::max_panels; ++i, panel = panel + 1.0) {
      const auto within = panel < panels;
      if (!M::any(within)) break;
      for (int node = 0; node < Rule::count; ++node) {
        const V t = half * (panel * 2.0 + (1 + Rule::abscissa(node)));
        const V angle = motion.omega * t + motion.turn_acceleration * angular(t).psi;
        const V distance = (motion.v + motion.acceleration * linear(t).phi) * Rule::weight(node);
        const Heading<V> heading = M::heading(angle);
        along = along + M::select(within, distance * heading.cosine, V(0.0));
        across = across + M::select(within, distance * heading.sine, V(0.0));
      }
    }
    return {along * half, across * half, motion.omega * time + motion.turn_acceleration * all.psi};
  }

  // Without viscous friction.
  NFOPIDN_INLINE static Displacement<V> unbraked(const Motion<V>& motion, const V& time) {
    const V h = time * 0.5;
    const V q = motion.turn_acceleration * (h * h) * 0.5;
    const V p = motion.omega * h + q * 2.0;
    const Heading<V> middle = M::small_heading(p - q);
    Displacement<V> way =
        around(middle, motion.v + motion.acceleration * h, motion.acceleration * h, p, q, time);
    way.turned = p * 2.0;
    const V bent = q * (most_turn / most_bend);
    if (__builtin_expect(!M::within(p, bent, most_turn), 0)) {
      // Copies: what a call is given lies in memory, and the rest need not.
      const Motion<V> copy = motion;
      const V copied_time = time;
      const Displacement<V> any = in_parts(copy, copied_time);
      const auto large = M::either(magnitude(p) > most_turn, magnitude(bent) > most_turn);
      way.along = M::select(large, any.along, way.along);
      way.across = M::select(large, any.across, way.across);
    }
    return way;
  }

  // The way of a part, which takes `time`, seen from the heading that `middle` is measured from: v
  // the speed in the middle, u what it gains from there to the end.
  NFOPIDN_INLINE static Displacement<V> around(const Heading<V>& middle, const V& v, const V& u,
                                               const V& p, const V& q, const V& time) {
    const Fresnel<V> f(p, q);
    const V ahead = (v * f.cosine - u * f.sine_bent) * time;
    const V beside = (v * f.cosine_bent + u * f.sine) * time;
    return {ahead * middle.cosine - beside * middle.sine,
            ahead * middle.sine + beside * middle.cosine, V(0.0)};
  }

  // In as many equal parts as make the angles of each small.
  NFOPIDN_NOINLINE static Displacement<V> in_parts(const Motion<V>& motion, const V& time) {
    constexpr int most_parts = 8 * exact::max_panels;  // for the same angle: a panel has 4 p
    const V last = motion.omega + motion.turn_acceleration * time;
    const V turn = M::maximum(magnitude(motion.omega), magnitude(last)) * time * (0.5 / most_turn);
    const V bend = magnitude(motion.turn_acceleration) * (time * time) * (0.125 / most_bend);
    // The root of a number is at most half of the number and one.
    const V wanted = M::maximum(turn, (bend + 1.0) * 0.5);
    const V parts = M::minimum(M::nearest(wanted + 0.5), V(double(most_parts)));
    const V each = time / parts;
    const V h = each * 0.5;
    const V q = motion.turn_acceleration * (h * h) * 0.5;
    const V u = motion.acceleration * h;
    const V zero(0.0), most(most_turn);
    Displacement<V> sum = {zero, zero, zero};
    V part(0.0);
    for (int i = 0; i < most_parts; ++i, part = part + 1.0) {
      const auto present = part < parts;
      if (!M::any(present)) break;
      const V t = h * (part * 2.0 + 1.0);
      const Heading<V> middle = M::heading((motion.omega + motion.turn_acceleration * t * 0.5) * t);
      // A spin too fast for the parts stays within bounds.
      const V p = M::maximum(M::minimum((motion.omega + motion.turn_acceleration * t) * h, most),
                             zero - most);
      const Displacement<V> one = around(middle, motion.v + motion.acceleration * t, u, p, q, each);
      sum.along = sum.along + M::select(present, one.along, zero);
      sum.across = sum.across + M::select(present, one.across, zero);
    }
    return sum;
  }

  NFOPIDN_INLINE static V magnitude(const V& a) { return M::maximum(a, a * -1.0); }
};

}  // namespace lanes

}  // namespace nfopidn
