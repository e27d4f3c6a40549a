// L4. The cost of a rival's parameters as an objective for the searches.
#pragma once

#include "nfopidn/rivals/rival_evaluator.hpp"
#include "nfopidn/tuning/family_objective.hpp"
#include "nfopidn/tuning/parameter_space.hpp"

namespace nfopidn::rivals {

class RivalObjective : public FamilyObjective {
 public:
  // The scenarios must outlive this. The design's parameters do not matter.
  RivalObjective(const std::vector<const Scenario*>& scenarios, const RivalDesign& design,
                 FreeParameters parameters, int dimension, FamilyCost family, int threads);

  bool has_gradient() const override {
    return std::all_of(evaluators_.begin(), evaluators_.end(),
                       [](const RivalEvaluator& one) { return one.has_gradient(); });
  }

 private:
  // Scenarios of the same sample time and peak speed, for which a candidate has the same numbers.
  struct Group {
    Model<double> model;
    int count = 0;                          // numbers of a candidate
    std::vector<double> numbers;            // [candidates][count]
    std::vector<double> point, directions;  // [count] and [directions][count]
  };

  Eigen::Index scenario_count() const override {
    return static_cast<Eigen::Index>(evaluators_.size());
  }
  double steps_of_a_candidate() const override {
    double steps = 0;
    for (const RivalEvaluator& one : evaluators_) steps += steps_of(one.run());
    return steps;
  }
  bool runs_one_by_one() const override { return !lane_law(design_.law); }

  void take(const Points& points) override;
  void run(Eigen::Index scenario, Eigen::Index first, Eigen::Index count, double* costs,
           const double* bounds) const override;
  void take_directions(const Point& point, Eigen::Index first, Eigen::Index count) override;
  double differentiate(Eigen::Index scenario, Eigen::Index first, Eigen::Index count,
                       double* slopes) const override {
    const Group& group = groups_[group_of_[static_cast<std::size_t>(scenario)]];
    const double* directions =
        group.directions.data() + static_cast<std::size_t>(first) * group.point.size();
    return evaluators_[static_cast<std::size_t>(scenario)].gradient(
        group.point, directions, static_cast<int>(count), slopes);
  }

  void join_group(const Model<double>& model) {
    const auto same = [&](const Group& group) {
      return group.model.dt == model.dt && group.model.peak_speed == model.peak_speed;
    };
    const auto found = std::find_if(groups_.begin(), groups_.end(), same);
    group_of_.push_back(static_cast<std::size_t>(found - groups_.begin()));
    if (found == groups_.end()) groups_.push_back({model, 0, {}, {}, {}});
  }

  std::vector<RivalEvaluator> evaluators_;
  RivalDesign design_;
  FreeParameters parameters_;
  std::vector<Group> groups_;
  std::vector<std::size_t> group_of_;       // of each scenario
  std::vector<std::vector<double>> every_;  // parameters of the candidates
};

}  // namespace nfopidn::rivals

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn::rivals {

NFOPIDN_HOST RivalObjective::RivalObjective(const std::vector<const Scenario*>& scenarios,
                                            const RivalDesign& design, FreeParameters parameters,
                                            int dimension, FamilyCost family, int threads)
    : FamilyObjective(dimension, std::move(family), threads),
      design_(design),
      parameters_(std::move(parameters)) {
  for (const Scenario* scenario : scenarios) {
    evaluators_.emplace_back(*scenario, design);
    join_group(evaluators_.back().model());
  }
}

NFOPIDN_HOST void RivalObjective::take(const Points& points) {
  every_.clear();
  for (Group& group : groups_) group.numbers.clear();
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    every_.push_back(parameters_.full(points.col(j).data()));
    if (runs_one_by_one()) continue;
    for (Group& group : groups_) {
      const std::vector<double> numbers = lane_numbers(design_, group.model, every_.back());
      group.count = static_cast<int>(numbers.size());
      group.numbers.insert(group.numbers.end(), numbers.begin(), numbers.end());
    }
  }
}

NFOPIDN_HOST void RivalObjective::run(Eigen::Index scenario, Eigen::Index first, Eigen::Index count,
                                      double* costs, const double* bounds) const {
  const RivalEvaluator& evaluator = evaluators_[static_cast<std::size_t>(scenario)];
  if (evaluator.has_lanes()) {
    const Group& group = groups_[group_of_[static_cast<std::size_t>(scenario)]];
    evaluator.costs(group.numbers, static_cast<int>(first), static_cast<int>(count), group.count,
                    costs, bounds);
    return;
  }
  for (Eigen::Index j = 0; j < count; ++j) {
    costs[j] = evaluator.cost(every_[static_cast<std::size_t>(first + j)]);
  }
}

NFOPIDN_HOST void RivalObjective::take_directions(const Point& point, Eigen::Index first,
                                                  Eigen::Index count) {
  std::vector<Dual<double>> x(static_cast<std::size_t>(dimension()));
  for (Group& group : groups_) group.directions.clear();
  for (Eigen::Index i = first; i < first + count; ++i) {
    for (Eigen::Index k = 0; k < dimension(); ++k) {
      x[static_cast<std::size_t>(k)] = {point(k), k == i ? 1.0 : 0.0};
    }
    const std::vector<Dual<double>> every = parameters_.full(x.data());
    for (Group& group : groups_) {
      group.point.clear();
      for (const Dual<double>& number : lane_numbers(design_, group.model, every)) {
        group.point.push_back(number.value);
        group.directions.push_back(number.slope);
      }
    }
  }
}

}  // namespace nfopidn::rivals

#endif  // NFOPIDN_DEFINES_TUNING
