// L4. All rivals, by name. A new one is a header, and a line in Laws.
#pragma once

#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/rivals/fierro_lewis.hpp"
#include "nfopidn/rivals/kanayama.hpp"
#include "nfopidn/rivals/lqr.hpp"
#include "nfopidn/rivals/ramsete.hpp"
#include "nfopidn/rivals/samson.hpp"
#include "nfopidn/rivals/sliding_mode.hpp"
#include "nfopidn/rivals/takagi_sugeno.hpp"
#include "nfopidn/simulation/simulate.hpp"
#include "nfopidn/tuning/structures.hpp"

namespace nfopidn::rivals {

using Laws = std::tuple<VelocityLoop<Samson<double>>,        //
                        VelocityLoop<Kanayama<double>>,      //
                        VelocityLoop<Ramsete<double>>,       //
                        VelocityLoop<Lqr<double>>,           //
                        VelocityLoop<TakagiSugeno<double>>,  //
                        SlidingMode<double>,                 //
                        FierroLewis<double>>;

constexpr std::size_t law_count = std::tuple_size_v<Laws>;

// Calls use(static_cast<Law*>(nullptr)) with the law at a place in Laws.
template <class Use, std::size_t place = 0>
decltype(auto) with_law(std::size_t law, Use&& use) {
  if constexpr (place + 1 < law_count) {
    if (law != place) return with_law<Use, place + 1>(law, std::forward<Use>(use));
  }
  return use(static_cast<std::tuple_element_t<place, Laws>*>(nullptr));
}

NFOPIDN_HOST std::string law_name(std::size_t law);

NFOPIDN_HOST std::vector<std::string> law_names();

struct RivalDesign {
  std::size_t law = 0;             // its place in Laws
  std::vector<double> parameters;  // in the order of for_each_parameter()
  Speeds speeds = Speeds::measured;
  bool integral = false;  // its gains follow those of the law
  Robot<double> robot;    // the model behind the torques

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    visit(field("speeds", &RivalDesign::speeds, "", any_number(),
                "where v and omega come from: the measurement, or the last two poses"));
    visit(field("integral", &RivalDesign::integral, "", any_number(),
                "whether the accelerations that the law asks for are also summed up"));
  }
};

// Calls visit(field) for each parameter of a law, and of its integral action.
template <class Visit>
void for_each_parameter(std::size_t law, bool integral, const Visit& visit) {
  with_law(law, [&](auto* own) { std::remove_pointer_t<decltype(own)>::Settings::fields(visit); });
  if (integral) IntegralGains<double>::fields(visit);
}

// The law's own settings, as parameters; without integral action where it may have some.
NFOPIDN_HOST std::vector<double> default_parameters(std::size_t law, bool integral = false);

NFOPIDN_HOST std::vector<ParameterBounds> law_bounds(std::size_t law, bool integral = false);

// A rival whose law is chosen at run time: the closed loop is compiled once for all of them.
class AnyRival {
 public:
  virtual ~AnyRival() = default;
  virtual void reset() = 0;
  virtual TorquePair<double> step(const Measurement<double>& measured,
                                  const ReferenceSample<double>& reference) = 0;
  virtual TorquePair<double> feedback() const = 0;
  virtual void set_torque_limit(double limit) = 0;
};

template <class Law, bool with_integral>
class RivalOf final : public AnyRival {
 public:
  template <class... Arguments>
  explicit RivalOf(const Arguments&... arguments) : rival_(arguments...) {}
  void reset() override { rival_.reset(); }
  TorquePair<double> step(const Measurement<double>& measured,
                          const ReferenceSample<double>& reference) override {
    return rival_.step(measured, reference);
  }
  TorquePair<double> feedback() const override { return rival_.feedback(); }
  void set_torque_limit(double limit) override { rival_.set_torque_limit(limit); }

 private:
  Rival<Law, with_integral> rival_;
};

// What the law of a design is built for in a run.
inline Model<double> model_of(const RivalDesign& design, const PreparedRun& run) {
  return {design.robot, run.scenario->trajectory.dt(), run.limits.speed_scale};
}

// Ready to run, its torques within a limit [N m].
NFOPIDN_HOST std::unique_ptr<AnyRival> make_rival(const RivalDesign& design,
                                                  const Model<double>& model, double torque_limit);
inline std::unique_ptr<AnyRival> make_rival(const RivalDesign& design, const PreparedRun& run) {
  return make_rival(design, model_of(design, run), run.limits.torque);
}

}  // namespace nfopidn::rivals

namespace nfopidn {

// The whole run, recorded. Scenario and parameters must be valid.
NFOPIDN_HOST SimulationResult simulate(const Scenario& scenario, const rivals::RivalDesign& design);

// The cost alone (eq. 41), without recording.
NFOPIDN_HOST double evaluate(const PreparedRun& run, const rivals::RivalDesign& design);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_RIVALS

namespace nfopidn::rivals {

NFOPIDN_HOST std::string law_name(std::size_t law) {
  return with_law(
      law, [](auto* own) { return std::string(std::remove_pointer_t<decltype(own)>::name); });
}

NFOPIDN_HOST std::vector<std::string> law_names() {
  std::vector<std::string> names;
  for (std::size_t law = 0; law < law_count; ++law) names.push_back(law_name(law));
  return names;
}

NFOPIDN_HOST std::vector<double> default_parameters(std::size_t law, bool integral) {
  return with_law(law, [&](auto* own) {
    typename std::remove_pointer_t<decltype(own)>::Settings settings;
    std::vector<double> parameters;
    decltype(settings)::fields([&](const auto& f) { parameters.push_back(settings.*f.member); });
    if (integral) {
      IntegralGains<double>::fields(
          [&](const auto& f) { parameters.push_back(IntegralGains<double>().*f.member); });
    }
    return parameters;
  });
}

NFOPIDN_HOST std::vector<ParameterBounds> law_bounds(std::size_t law, bool integral) {
  std::vector<ParameterBounds> bounds;
  for_each_parameter(law, integral, [&](const auto& f) {
    bounds.push_back({f.name, f.range.low, f.range.high});
  });
  return bounds;
}

NFOPIDN_HOST std::unique_ptr<AnyRival> make_rival(const RivalDesign& design,
                                                  const Model<double>& model, double torque_limit) {
  return with_law(design.law, [&](auto* own) -> std::unique_ptr<AnyRival> {
    using Law = std::remove_pointer_t<decltype(own)>;
    typename Law::Settings settings;
    const double* rest = take_parameters(design.parameters.data(), settings);
    const Law law(settings, model);
    if (!design.integral) {
      return std::make_unique<RivalOf<Law, false>>(law, model, torque_limit, design.speeds);
    }
    IntegralGains<double> gains;
    take_parameters(rest, gains);
    return std::make_unique<RivalOf<Law, true>>(law, model, torque_limit, design.speeds, gains);
  });
}

}  // namespace nfopidn::rivals

namespace nfopidn {

NFOPIDN_HOST SimulationResult simulate(const Scenario& scenario,
                                       const rivals::RivalDesign& design) {
  const StandardArithmetic arithmetic;
  const PreparedRun run = prepare(scenario);
  return detail::record(run, *rivals::make_rival(design, run));
}

NFOPIDN_HOST double evaluate(const PreparedRun& run, const rivals::RivalDesign& design) {
  const StandardArithmetic arithmetic;
  const std::unique_ptr<rivals::AnyRival> law = rivals::make_rival(design, run);
  const auto ignore = [](int, auto&&...) {};
  return run_closed_loop<double>(run.plant, *law, run.start, run.inputs(), ignore, run.poll()).cost;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_RIVALS
