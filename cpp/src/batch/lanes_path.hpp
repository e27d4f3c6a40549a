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

#include "lanes_relaxation.hpp"
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
  if constexpr (terms == 1) {
    return V(coefficients[0]);
  } else {
    V sum = x * coefficients[terms - 1] + coefficients[terms - 2];
    for (int i = terms - 3; i >= 0; --i) sum = sum * x + coefficients[i];
    return sum;
  }
}

template <class V>
NFOPIDN_INLINE V in_powers(const V& /*y*/, const V& last) {
  return last;
}
template <class V, class... Rest>
NFOPIDN_INLINE V in_powers(const V& y, const V& first, const Rest&... rest) {
  return in_powers(y, rest...) * y + first;
}

// The integrals from 0 to 1 of cos(p s) e^{i q s^2} and of s sin(p s) e^{i q s^2} ds, real and
// imaginary parts, by Chebyshev series in p^2 and q^2. Absolute errors under 1e-13.
template <class V>
struct Fresnel {
  V cosine, cosine_bent, sine, sine_bent;
};

// For |p| <= most_turn and |q| <= most_bend.
struct Narrow {
  static constexpr double most_turn = 0.25;
  static constexpr double most_bend = 0.0625;

  template <class V>
  NFOPIDN_INLINE static Fresnel<V> integrals(const V& p, const V& q) {
    constexpr double c0[] = {0.99999999999999698776, -0.1666666666664134934,
                             0.0083333333187832197413, -0.00019841224469588505859,
                             2.749960165639440248e-6};
    constexpr double c1[] = {-0.099999999987376428964, 0.035714285225764014176,
                             -0.0023148087232493838412, 0.000062997136293443827636};
    constexpr double c2[] = {0.0046296211254235518262, -0.001893659681181857755,
                             0.00013316584488555796933};
    constexpr double c3[] = {-0.00010538458792033550202};
    constexpr double cb0[] = {0.33333333333275398399, -0.099999999783532720409,
                              0.0059523666574917995158, -0.00015400467744729384925};
    constexpr double cb1[] = {-0.023809523516352310504, 0.0092592145076822197861,
                              -0.0006295555090603936517};
    constexpr double cb2[] = {0.00075748698086774074022, -0.00031903451963894529301};
    constexpr double s0[] = {0.33333333333328118825, -0.033333333315277223851,
                             0.0011904749241850118767, -0.000022014560480323146425};
    constexpr double s1[] = {-0.07142857138082447362, 0.0092592534932170024966,
                             -0.00037869701706031137005, 7.6178870111043074558e-6};
    constexpr double s2[] = {0.0037878649926893727142, -0.00053266349806615947522};
    constexpr double s3[] = {-0.000092157816933818420335};
    constexpr double sb0[] = {0.19999999999991642698, -0.02380952378666438625,
                              0.00092592448104325143692, -0.000018006740213211085002};
    constexpr double sb1[] = {-0.018518518393777333853, 0.0025252466768188845347,
                              -0.00010661518758926420117};
    constexpr double sb2[] = {0.0006409552667287833197, -0.000092327431897322048792};
    const V x = p * p;
    const V y = q * q;
    return {in_powers(y, horner(x, c0), horner(x, c1), horner(x, c2), horner(x, c3)),
            in_powers(y, horner(x, cb0), horner(x, cb1), horner(x, cb2)) * q,
            in_powers(y, horner(x, s0), horner(x, s1), horner(x, s2), horner(x, s3)) * p,
            in_powers(y, horner(x, sb0), horner(x, sb1), horner(x, sb2)) * (p * q)};
  }
};

// The same, with more terms for larger angles.
struct Wide {
  static constexpr double most_turn = 1;
  static constexpr double most_bend = 0.25;

  template <class V>
  NFOPIDN_INLINE static Fresnel<V> integrals(const V& p, const V& q) {
    constexpr double c0[] = {0.99999999999999760214,   -0.16666666666655462569,
                             0.0083333333321712976083, -0.00019841269359974978721,
                             2.7557223639526534891e-6, -2.5042537833382989628e-8,
                             1.5605479707571392168e-10};
    constexpr double c1[] = {-0.099999999999490535293,  0.035714285704752164732,
                             -0.0023148147537587251938, 0.000063131119253918441619,
                             -9.5360666744320383874e-7, 8.9663318161948541072e-9};
    constexpr double c2[] = {0.0046296295959319564788, -0.0018939390642407713977,
                             0.00013354611728843133597, -3.8564159171193029099e-6,
                             5.9144595040541709858e-8};
    constexpr double c3[] = {-0.00010683674323439953135, 0.000046289874876182341224,
                             -3.3959852923216020644e-6, 9.8111741909085243559e-8};
    constexpr double c4[] = {1.4509553042187854764e-6, -6.0398084894063741225e-7};
    constexpr double cb0[] = {0.33333333333320563785,   -0.099999999993821189294,
                              0.005952380889478608303,  -0.00015432073687299606437,
                              2.2542204450474371862e-6, -2.0784166225245412577e-8};
    constexpr double cb1[] = {-0.023809523794613914711,   0.0092592590727441893396,
                              -0.00063131224882230782417, 0.00001780486928309877654,
                              -2.7483322987741035053e-7,  2.6405875466527396064e-9};
    constexpr double cb2[] = {0.0007575749297665154909, -0.00032050916925276721128,
                              0.000023132996886823741051, -6.5818740162169313317e-7};
    constexpr double cb3[] = {-0.00001320899742327294759, 5.820285499741252217e-6,
                              -4.1520664564484594141e-7};
    constexpr double s0[] = {0.33333333333331373222,   -0.033333333332881044476,
                             0.0011904761859733100734, -0.000022045836714161999933,
                             2.5048527186185482885e-7, -1.8951979292284530303e-9};
    constexpr double s1[] = {-0.071428571421869392586,   0.0092592592309436794071,
                             -0.00037878783161416567934, 7.6312148740802994264e-6,
                             -9.1835645768931727058e-8,  7.2120398703031539132e-10};
    constexpr double s2[] = {0.0037878782842420411017, -0.00053418639212465682093,
                             0.000023146251252829254727, -4.8496967951024811994e-7,
                             5.9049373126715258806e-9};
    constexpr double s3[] = {-0.000092580218540790537387, 0.000013584749437776115871,
                             -5.886806173179653934e-7};
    constexpr double s4[] = {1.2085043459879187125e-6};
    constexpr double sb0[] = {0.19999999999988962239,    -0.02380952380781772939,
                              0.00092592591558635887722, -0.000018037485913615533324,
                              2.1193047645628740066e-7,  -1.6352930164977484257e-9};
    constexpr double sb1[] = {-0.018518518488558014097, 0.0025252523169254640054,
                              -0.00010683718127403474339, 2.2039735266516770275e-6,
                              -2.6405953715390759146e-8};
    constexpr double sb2[] = {0.00064102409584978689548, -0.000092585004807623211836,
                              4.0762488639469075129e-6, -8.4705091734368634495e-8};
    constexpr double sb3[] = {-0.000011645378977122244987, 1.6609307039561461503e-6};
    const V x = p * p;
    const V y = q * q;
    return {
        in_powers(y, horner(x, c0), horner(x, c1), horner(x, c2), horner(x, c3), horner(x, c4)),
        in_powers(y, horner(x, cb0), horner(x, cb1), horner(x, cb2), horner(x, cb3)) * q,
        in_powers(y, horner(x, s0), horner(x, s1), horner(x, s2), horner(x, s3), horner(x, s4)) * p,
        in_powers(y, horner(x, sb0), horner(x, sb1), horner(x, sb2), horner(x, sb3)) * (p * q)};
  }
};

template <class V>
using Motion = exact::ExponentialMotion<V, double>;
// With rates of each lane's own.
template <class V>
using BrakedMotion = exact::ExponentialMotion<V, V>;

template <class V>
struct Travel {
  using M = math<V>;

  // By quadrature, whatever the angles. No time is longer than `longest`.
  template <class Rate>
  NFOPIDN_NOINLINE static Displacement<V> by_quadrature(
      const exact::ExponentialMotion<V, Rate>& motion, const V& time, double longest) {
    using Rule = exact::Quadrature<double>;
    const Relaxation<V, Rate> linear(motion.rate, longest);
    const Relaxation<V, Rate> angular(motion.turn_rate, longest);
    const exact::Decay<V> all = angular(time);
    const V last_omega = motion.omega + motion.turn_acceleration * all.phi;
    const V turned = (magnitude(motion.omega) + magnitude(last_omega)) * time;
    const V wanted = M::maximum(turned, time * larger(motion.rate, motion.turn_rate)) * 0.5;
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
    Displacement<V> way = around<Narrow>(middle, motion.v + motion.acceleration * h,
                                         motion.acceleration * h, p, q, time);
    way.turned = p * 2.0;
    constexpr double most_turn = Narrow::most_turn;
    const V bent = q * (most_turn / Narrow::most_bend);
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
  template <class Series>
  NFOPIDN_INLINE static Displacement<V> around(const Heading<V>& middle, const V& v, const V& u,
                                               const V& p, const V& q, const V& time) {
    const Fresnel<V> f = Series::integrals(p, q);
    const V ahead = (v * f.cosine - u * f.sine_bent) * time;
    const V beside = (v * f.cosine_bent + u * f.sine) * time;
    return {ahead * middle.cosine - beside * middle.sine,
            ahead * middle.sine + beside * middle.cosine, V(0.0)};
  }

  // In as many equal parts as make the angles of each small.
  NFOPIDN_NOINLINE static Displacement<V> in_parts(const Motion<V>& motion, const V& time) {
    constexpr double most_turn = Wide::most_turn;
    constexpr int most_parts = exact::max_panels;
    const V last = motion.omega + motion.turn_acceleration * time;
    const V turn = M::maximum(magnitude(motion.omega), magnitude(last)) * time * (0.5 / most_turn);
    const V bend = magnitude(motion.turn_acceleration) * (time * time) * (0.125 / Wide::most_bend);
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
      const Displacement<V> one =
          around<Wide>(middle, motion.v + motion.acceleration * t, u, p, q, each);
      sum.along = sum.along + M::select(present, one.along, zero);
      sum.across = sum.across + M::select(present, one.across, zero);
    }
    return sum;
  }

  NFOPIDN_INLINE static V magnitude(const V& a) { return M::maximum(a, a * -1.0); }
  NFOPIDN_INLINE static V larger(const V& a, const V& b) { return M::maximum(a, b); }
  NFOPIDN_INLINE static double larger(double a, double b) { return a > b ? a : b; }
};

}  // namespace lanes

}  // namespace nfopidn
