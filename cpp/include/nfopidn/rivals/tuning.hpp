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

  bool is_cheap() const override { return !runs_one_by_one(); }
  bool has_gradient() const override {
    return std::all_of(evaluators_.begin(), evaluators_.end(),
                       [](const RivalEvaluator& one) { return one.has_gradient(); });
  }

 private:
  Eigen::Index scenario_count() const override {
    return static_cast<Eigen::Index>(evaluators_.size());
  }
  double steps_of_a_candidate() const override {
    double steps = 0;
    for (const RivalEvaluator& one : evaluators_) steps += steps_of(one.run());
    return steps;
  }
  bool runs_one_by_one() const override {
    return std::none_of(evaluators_.begin(), evaluators_.end(),
                        [](const RivalEvaluator& one) { return one.has_lanes(); });
  }

  // The parameters of the candidates, [candidates][parameters], and for each group of scenarios
  // what its lanes are given, [candidates][numbers]; nothing for one without lanes.
  Numbers numbers_of(const Points& points) const override;
  void run(const Numbers& numbers, Eigen::Index scenario, Eigen::Index first, Eigen::Index count,
           double* costs, const double* bounds) const override;
  // Two lists for each group: the numbers of the point, and how they change,
  // [directions][numbers].
  Numbers directions_of(const Point& point, Eigen::Index first, Eigen::Index count) const override;
  double differentiate(const Numbers& numbers, Eigen::Index scenario, Eigen::Index first,
                       Eigen::Index count, double* slopes) const override {
    const std::size_t group = group_of_[static_cast<std::size_t>(scenario)];
    const std::vector<double>& point = numbers[2 * group];
    return evaluators_[static_cast<std::size_t>(scenario)].gradient(
        point, numbers[2 * group + 1].data() + static_cast<std::size_t>(first) * point.size(),
        static_cast<int>(count), slopes);
  }

  // Of scenarios of the same sample time and peak speed a candidate has the same numbers.
  struct Group {
    Model<double> model;
    bool has_lanes = false;  // of one of its scenarios
  };
  void join_group(const RivalEvaluator& evaluator) {
    const Model<double>& model = evaluator.model();
    const auto same = [&](const Group& group) {
      return group.model.dt == model.dt && group.model.peak_speed == model.peak_speed;
    };
    auto found = std::find_if(groups_.begin(), groups_.end(), same);
    group_of_.push_back(static_cast<std::size_t>(found - groups_.begin()));
    if (found == groups_.end()) found = groups_.insert(found, {model});
    found->has_lanes = found->has_lanes || evaluator.has_lanes();
  }

  std::vector<RivalEvaluator> evaluators_;
  RivalDesign design_;
  FreeParameters parameters_;
  std::vector<Group> groups_;
  std::vector<std::size_t> group_of_;  // of each scenario
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
    join_group(evaluators_.back());
  }
}

NFOPIDN_HOST FamilyObjective::Numbers RivalObjective::numbers_of(const Points& points) const {
  Numbers numbers(1 + groups_.size());
  const auto append = [](std::vector<double>& list, const std::vector<double>& own) {
    list.insert(list.end(), own.begin(), own.end());
  };
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const std::vector<double> parameters = parameters_.full(points.col(j).data());
    append(numbers[0], parameters);
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      const Group& group = groups_[i];
      if (group.has_lanes) append(numbers[1 + i], lane_numbers(design_, group.model, parameters));
    }
  }
  return numbers;
}

NFOPIDN_HOST void RivalObjective::run(const Numbers& numbers, Eigen::Index scenario,
                                      Eigen::Index first, Eigen::Index count, double* costs,
                                      const double* bounds) const {
  const auto place = static_cast<std::size_t>(scenario);
  const RivalEvaluator& evaluator = evaluators_[place];
  const std::size_t size = parameters_.source.size();
  if (evaluator.has_lanes()) {
    const std::vector<double>& list = numbers[1 + group_of_[place]];
    const std::size_t candidates = numbers[0].size() / size;
    evaluator.costs(list, static_cast<int>(first), static_cast<int>(count),
                    static_cast<int>(list.size() / candidates), costs, bounds);
    return;
  }
  for (Eigen::Index j = 0; j < count; ++j) {
    const double* own = numbers[0].data() + static_cast<std::size_t>(first + j) * size;
    costs[j] = evaluator.cost({own, own + size});
  }
}

NFOPIDN_HOST FamilyObjective::Numbers RivalObjective::directions_of(const Point& point,
                                                                    Eigen::Index first,
                                                                    Eigen::Index count) const {
  Numbers numbers(2 * groups_.size());
  std::vector<Dual<double>> x(static_cast<std::size_t>(dimension()));
  for (Eigen::Index i = first; i < first + count; ++i) {
    for (Eigen::Index k = 0; k < dimension(); ++k) {
      x[static_cast<std::size_t>(k)] = {point(k), k == i ? 1.0 : 0.0};
    }
    const std::vector<Dual<double>> parameters = parameters_.full(x.data());
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      numbers[2 * g].clear();
      for (const Dual<double>& one : lane_numbers(design_, groups_[g].model, parameters)) {
        numbers[2 * g].push_back(one.value);
        numbers[2 * g + 1].push_back(one.slope);
      }
    }
  }
  return numbers;
}

}  // namespace nfopidn::rivals

#endif  // NFOPIDN_DEFINES_TUNING
