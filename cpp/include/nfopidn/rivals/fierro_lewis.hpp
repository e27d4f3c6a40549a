// L4. Back-stepping into torque: R. Fierro, F. L. Lewis, "Control of a nonholonomic mobile robot:
// backstepping kinematics into dynamics", 34th IEEE CDC 1995. The velocities of Kanayama's law and
// their rates of change, by computed torque: u = d(v_c)/dt + k_4 (v_c - v).
#pragma once

#include "nfopidn/rivals/kanayama.hpp"

namespace nfopidn::rivals {

template <class Number>
class FierroLewis {
 public:
  using Scalar = Number;
  static constexpr const char* name = "fierro-lewis";

  struct Settings : KanayamaGains {
    double k_4 = 0.495017;

    constexpr Settings() : KanayamaGains{0.607785, 10.271, 33.5514} {}

    template <class Visitor>
    static constexpr void fields(Visitor&& visit) {
      KanayamaGains::fields(visit);
      visit(field("k_4", &Settings::k_4, "1/s", between(0, 10), "of both velocity loops"));
    }
  };

  FierroLewis(const Settings& settings, const Model<Scalar>& model)
      : kinematics_(settings, model), k_4_(Scalar(settings.k_4)) {}

  constexpr void reset() noexcept {}

  constexpr Accelerations<Scalar> feedback(const View<Scalar>& view) const noexcept {
    const Velocity<Scalar> command = kinematics_.command(view);
    const Accelerations<Scalar> slope = kinematics_.slope(view);
    return {slope.linear + k_4_ * (command.v - view.speed.v) - view.acceleration.linear,
            slope.angular + k_4_ * (command.omega - view.speed.omega) - view.acceleration.angular};
  }

 private:
  Kanayama<Scalar> kinematics_;
  Scalar k_4_;
};

}  // namespace nfopidn::rivals
