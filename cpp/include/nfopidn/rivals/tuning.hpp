// L4. The cost of a rival's parameters as an objective for the searches.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/rivals/rivals.hpp"
#include "nfopidn/tuning/tune.hpp"

namespace nfopidn::rivals {

// As TuneObjective, one candidate at a time and without exact gradients.
class RivalObjective : public Objective {
 public:
  // The scenarios must outlive this. The design's parameters do not matter.
  RivalObjective(const std::vector<const Scenario*>& scenarios, RivalDesign design,
                 FreeParameters parameters, FamilyCost family, int threads);

  // A moment's worth, as a time limit is looked at in between.
  Eigen::Index most_at_once() const override;

  void costs(const Points& points, double* costs) override;

 private:
  double cost(const Point& point) const;

  std::vector<PreparedRun> runs_;
  RivalDesign design_;
  FreeParameters parameters_;
  FamilyCost family_;
  ThreadPool pool_;
};

}  // namespace nfopidn::rivals

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn::rivals {

NFOPIDN_HOST RivalObjective::RivalObjective(const std::vector<const Scenario*>& scenarios,
                                            RivalDesign design, FreeParameters parameters,
                                            FamilyCost family, int threads)
    : design_(std::move(design)),
      parameters_(std::move(parameters)),
      family_(std::move(family)),
      pool_(threads) {
  for (const Scenario* scenario : scenarios) runs_.push_back(prepare(*scenario));
}

NFOPIDN_HOST Eigen::Index RivalObjective::most_at_once() const {
  constexpr double steps = 512.0 * 751;
  double each = 0;
  for (const PreparedRun& run : runs_) {
    each += static_cast<double>(run.reference.size()) * run.scenario->substeps;
  }
  return std::max<Eigen::Index>(pool_.size(), static_cast<Eigen::Index>(steps / each));
}

NFOPIDN_HOST void RivalObjective::costs(const Points& points, double* costs) {
  pool_.for_each_share(points.cols(), 1, [&](Eigen::Index first, Eigen::Index count) {
    for (Eigen::Index j = first; j < first + count; ++j) costs[j] = cost(points.col(j));
  });
}

NFOPIDN_HOST double RivalObjective::cost(const Point& point) const {
  RivalDesign candidate = design_;
  candidate.parameters = parameters_.full(point.data());
  Eigen::VectorXd each(static_cast<Eigen::Index>(runs_.size()));
  for (std::size_t s = 0; s < runs_.size(); ++s) {
    each(static_cast<Eigen::Index>(s)) = evaluate(runs_[s], candidate);
  }
  family_.see(each);
  return each.dot(worst_share_weights(each, family_.share));
}

}  // namespace nfopidn::rivals

#endif  // NFOPIDN_DEFINES_TUNING
