// L4. Makes a controller of a law that asks for velocities: torques in proportion to what is
// missing of them, through the model. The reference's torques are added as for every controller.
#pragma once

#include <utility>

#include "nfopidn/rivals/rival.hpp"

namespace nfopidn::rivals {

// A Kinematics has Settings, a name, a Kinematics(settings, model), and command(View).
template <class Kinematics>
class VelocityLoop {
 public:
  using Scalar = typename Kinematics::Scalar;
  static constexpr const char* name = Kinematics::name;

  struct Settings : Kinematics::Settings {
    Scalar k_v = Scalar(Kinematics::Settings::tuned_k_v);
    Scalar k_omega = Scalar(Kinematics::Settings::tuned_k_omega);

    template <class Visitor>
    static constexpr void fields(Visitor&& visit) {
      Kinematics::Settings::fields(visit);
      visit(field("k_v", &Settings::k_v, "1/s", between(0, 10), "of the speed's loop"));
      visit(field("k_omega", &Settings::k_omega, "1/s", between(0, 10), "of the turning rate's"));
    }
  };

  VelocityLoop(const Settings& settings, const Model<base_t<Scalar>>& model)
      : VelocityLoop(Kinematics(settings, model), settings.k_v, settings.k_omega) {}
  VelocityLoop(Kinematics kinematics, const Scalar& k_v, const Scalar& k_omega)
      : kinematics_(std::move(kinematics)), k_v_(k_v), k_omega_(k_omega) {}

  constexpr void reset() noexcept {}

  NFOPIDN_INLINE constexpr Accelerations<Scalar> feedback(const View<Scalar>& view) const noexcept {
    const Velocity<Scalar> command = kinematics_.command(view);
    return {(command.v - view.speed.v) * k_v_, (command.omega - view.speed.omega) * k_omega_};
  }

  constexpr const Kinematics& kinematics() const noexcept { return kinematics_; }

 private:
  Kinematics kinematics_;
  Scalar k_v_;
  Scalar k_omega_;
};

}  // namespace nfopidn::rivals
