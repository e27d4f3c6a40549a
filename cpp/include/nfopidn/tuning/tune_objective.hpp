// L4. The cost of a controller's parameters as an objective for the searches.
#pragma once

#include "nfopidn/tuning/batch.hpp"
#include "nfopidn/tuning/family_objective.hpp"
#include "nfopidn/tuning/parameter_space.hpp"

namespace nfopidn {

// Cost of a controller over scenarios, of which FamilyCost makes one.
class TuneObjective : public FamilyObjective {
 public:
  // The scenarios must outlive this.
  TuneObjective(const std::vector<const Scenario*>& scenarios, const ParameterSpace& space,
                FamilyCost family, int threads);

  bool has_gradient() const override { return true; }
  bool is_cheap() const override { return true; }

 private:
  Eigen::Index scenario_count() const override {
    return static_cast<Eigen::Index>(evaluators_.size());
  }
  double steps_of_a_candidate() const override {
    double steps = 0;
    for (const BatchEvaluator& one : evaluators_) steps += steps_of(one.run());
    return steps;
  }
  // A memory beyond that of the lanes, or a pose by odometry, which they do not have.
  bool runs_one_by_one() const override {
    return structure_.settings.memory + 2 > batch_capacity ||
           std::any_of(evaluators_.begin(), evaluators_.end(),
                       [](const BatchEvaluator& one) { return one.run().encoders.has_value(); });
  }

  // One list: the laws of the candidates, [candidates][law_size].
  Numbers numbers_of(const Points& points) const override;
  void run(const Numbers& numbers, Eigen::Index scenario, Eigen::Index first, Eigen::Index count,
           double* costs, const double* bounds) const override {
    evaluators_[static_cast<std::size_t>(scenario)].costs_of_laws(
        numbers[0].data() + static_cast<std::size_t>(first) * law_size(), static_cast<int>(count),
        costs, bounds);
  }

  // Two lists: the law of the point, [law_size], and how it changes, [directions][law_size].
  Numbers directions_of(const Point& point, Eigen::Index first, Eigen::Index count) const override;
  double differentiate(const Numbers& numbers, Eigen::Index scenario, Eigen::Index first,
                       Eigen::Index count, double* slopes) const override {
    return evaluators_[static_cast<std::size_t>(scenario)].gradient(
        numbers[0].data(), numbers[1].data() + static_cast<std::size_t>(first) * law_size(),
        static_cast<int>(count), slopes);
  }

  std::size_t law_size() const {
    return static_cast<std::size_t>(
        nfopidn::law_size(structure_.settings, structure_.settings.memory + 2));
  }

  std::vector<BatchEvaluator> evaluators_;
  Structure structure_;
  FreeParameters parameters_;
};

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn {

NFOPIDN_HOST TuneObjective::TuneObjective(const std::vector<const Scenario*>& scenarios,
                                          const ParameterSpace& space, FamilyCost family,
                                          int threads)
    : FamilyObjective(space.dimension(), std::move(family), threads),
      structure_(space.structure),
      parameters_(space.parameters) {
  for (const Scenario* scenario : scenarios) {
    evaluators_.emplace_back(prepare(*scenario), structure_.settings);
  }
}

NFOPIDN_HOST FamilyObjective::Numbers TuneObjective::numbers_of(const Points& points) const {
  const std::size_t size = law_size();
  std::vector<double> laws(static_cast<std::size_t>(points.cols()) * size);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    parameters_to_law(structure_, parameters_.full(points.col(j).data()),
                      laws.data() + static_cast<std::size_t>(j) * size);
  }
  return {std::move(laws)};
}

NFOPIDN_HOST FamilyObjective::Numbers TuneObjective::directions_of(const Point& point,
                                                                   Eigen::Index first,
                                                                   Eigen::Index count) const {
  const std::size_t size = law_size();
  std::vector<double> law(size), directions(size * static_cast<std::size_t>(count));
  std::vector<Dual<double>> x(static_cast<std::size_t>(dimension())), fused(size);
  double* slope = directions.data();
  for (Eigen::Index i = first; i < first + count; ++i) {
    for (Eigen::Index k = 0; k < dimension(); ++k) {
      x[static_cast<std::size_t>(k)] = {point(k), k == i ? 1.0 : 0.0};
    }
    parameters_to_law(structure_, parameters_.full(x.data()), fused.data());
    for (std::size_t n = 0; n < size; ++n) {
      law[n] = fused[n].value;
      *slope++ = fused[n].slope;
    }
  }
  return {std::move(law), std::move(directions)};
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_TUNING
