// L3. A run under given torques, without a controller.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/simulation/simulate.hpp"

namespace nfopidn {

// In the place of a law: the total torques of each sample, whatever is measured.
class Playback {
 public:
  // A torque for each sample of the run; borrowed.
  explicit Playback(const std::vector<TorquePair<double>>& torques) : torques_(torques) {}

  void reset() noexcept { next_ = 0; }

  TorquePair<double> step(const Measurement<double>& /*measured*/,
                          const ReferenceSample<double>& reference) {
    const TorquePair<double> torque = torques_[next_++];
    feedback_ = {torque.left - reference.tau_left, torque.right - reference.tau_right};
    return torque;
  }

  // What the last torque adds to the reference's.
  TorquePair<double> feedback() const noexcept { return feedback_; }

 private:
  const std::vector<TorquePair<double>>& torques_;
  std::size_t next_ = 0;
  TorquePair<double> feedback_ = {0, 0};
};

// The whole run, recorded. The scenario must be valid, and the torques within its limit.
NFOPIDN_HOST SimulationResult play(const Scenario& scenario,
                                   const std::vector<TorquePair<double>>& torques);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn {

NFOPIDN_HOST SimulationResult play(const Scenario& scenario,
                                   const std::vector<TorquePair<double>>& torques) {
  const StandardArithmetic arithmetic;
  const PreparedRun run = prepare(scenario);
  Playback playback(torques);
  return detail::record(run, playback);
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
