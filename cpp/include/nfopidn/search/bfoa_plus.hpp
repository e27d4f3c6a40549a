// L3. Cognitive bacterial foraging: the same skeleton, improved where measurement says so.
//
// Cells start from a Latin hypercube, half of it drawn towards the box's lower corner, where a
// controller's gains are small and its loop is stable. They compare costs by rank only, so that
// the costs of diverging ones do not outweigh the others. A cell tumbles in few coordinates by a
// step that adapts to its success, and swims on while that pays; or it tumbles along differences
// between cells of its colony, with a reach and a share of coordinates learnt from what succeeded.
// Colonies do not see each other, so that they end in different valleys. A cell never moves to a
// worse place. A quasi-Newton descent finishes from the best cells, then from new places, or where
// a good one was given from jumps away from the best point. Without gradients tumbles along
// differences prevail, one cell is descended from, and the rest looks along each coordinate, over
// the whole of the box, for other pits: where the coordinates act apart from each other, that is
// where they are.
#pragma once

#include "nfopidn/search/bfoa_plus_options.hpp"
#include "nfopidn/search/differential_tumbles.hpp"
#include "nfopidn/search/latin_hypercube.hpp"
#include "nfopidn/search/quasi_newton.hpp"

namespace nfopidn {

class BfoaPlus {
 public:
  using Options = BfoaPlusOptions;
  static constexpr const char* name = "bfoa+";
  static constexpr std::int64_t default_budget = 10000;

  BfoaPlus(SearchSession& search, const BfoaPlusOptions& options)
      : BfoaPlus(search, options, search.left()) {}
  BfoaPlus(SearchSession& search, const BfoaPlusOptions& options, std::int64_t budget)
      : search_(search), options_(options), budget_(budget) {}

  void run() {
    differential_share_ = search_.objective().has_gradient() ? options_.differential_share
                                                             : options_.blind_differential_share;
    first_cells();
    const double share = search_.objective().has_gradient() ? options_.foraging_share
                                                            : options_.blind_foraging_share;
    const auto foraging = static_cast<std::int64_t>(share * static_cast<double>(budget_));
    for (int j = 0; search_.result.evaluations < foraging && !search_.done(); ++j) {
      forage();
      search_.note(0, 0, j, cells_, costs_, mean(steps_));
    }
    if (!search_.done()) finish();
    search_.spend();
    end_history();
  }

 private:
  enum class Move : unsigned char { differential, sparse, swim };

  double uniform() { return search_.random.uniform(); }
  Eigen::Index pick(Eigen::Index count) {
    return static_cast<Eigen::Index>(uniform() * static_cast<double>(count));
  }

  void first_cells() {
    const Eigen::Index p = search_.dimension();
    const auto wanted = static_cast<Eigen::Index>(
        std::min<std::int64_t>(options_.first_points, std::max<std::int64_t>(budget_ / 10, 4)));
    const Eigen::Index count = std::max<Eigen::Index>(wanted, 4);
    Points points = latin_hypercube(search_.random, p, count);
    // Half of them drawn towards the lower corner.
    for (Eigen::Index k = 1; k < count; k += 2) points.col(k) = points.col(k).array().cube();
    if (search_.start.size() != 0) surround(search_.box().to_unit(search_.start), points);
    const Eigen::Index cells = std::min<Eigen::Index>(wanted_cells(), count);
    const Eigen::VectorXd costs = search_.evaluate_least(points, cells);
    const std::vector<Eigen::Index> order = ranking(costs);
    cells_.resize(p, cells);
    costs_.resize(cells);
    for (Eigen::Index k = 0; k < cells; ++k) {
      cells_.col(k) = points.col(order[static_cast<std::size_t>(k)]);
      costs_(k) = costs(order[static_cast<std::size_t>(k)]);
    }
    steps_ = Eigen::VectorXd::Constant(cells, options_.step);
    headings_ = Points::Zero(p, cells);
    swimming_.assign(static_cast<std::size_t>(cells), 0);
    order_.resize(static_cast<std::size_t>(cells));
    for (std::size_t k = 0; k < order_.size(); ++k) order_[k] = static_cast<Eigen::Index>(k);
  }

  int wanted_cells() const {
    if (!search_.objective().has_gradient()) return options_.blind_cells;
    const std::int64_t affordable = budget_ / options_.evaluations_per_cell;
    return std::max(4, static_cast<int>(std::min<std::int64_t>(options_.cells, affordable)));
  }

  // A known point takes the place of the first, and sparse steps from it that of every second.
  void surround(const Point& known, Points& points) {
    points.col(0) = known;
    for (Eigen::Index k = 2; k < points.cols(); k += 2) {
      points.col(k) = known;
      sparse(options_.step, points.col(k));
    }
  }

  // One chemotactic step of every cell.
  void forage() {
    const Eigen::Index count = cells_.cols();
    gather_colonies();
    places_.resize(cells_.rows(), count);
    moves_.resize(static_cast<std::size_t>(count));
    sizes_.resize(static_cast<std::size_t>(count));
    for (Eigen::Index k = 0; k < count; ++k) {
      Move& move = moves_[static_cast<std::size_t>(k)];
      if (swimming_[static_cast<std::size_t>(k)] != 0) {
        move = Move::swim;
        places_.col(k) = clip_to_box(cells_.col(k) + headings_.col(k));
      } else if (uniform() < differential_share_) {
        move = Move::differential;
        sizes_[static_cast<std::size_t>(k)] =
            differential_.tumble(search_.random, cells_, colony_of(k), k, places_.col(k).data());
      } else {
        move = Move::sparse;
        places_.col(k) = cells_.col(k);
        sparse(steps_(k), places_.col(k));
      }
    }
    search_.evaluate(places_, found_, &costs_);
    settle(found_);
  }

  // Moves the cells that found better, and learns from it.
  void settle(const Eigen::VectorXd& costs) {
    for (Eigen::Index k = 0; k < cells_.cols(); ++k) {
      const Move move = moves_[static_cast<std::size_t>(k)];
      const bool better = costs(k) < costs_(k);
      if (better) {
        headings_.col(k) = places_.col(k) - cells_.col(k);
        cells_.col(k) = places_.col(k);
        costs_(k) = costs(k);
      }
      swimming_[static_cast<std::size_t>(k)] = better && move != Move::differential ? 1 : 0;
      if (move == Move::sparse) {
        steps_(k) = std::min(0.5, std::max(1e-6, steps_(k) * (better ? 1.6 : 0.9)));
      } else if (move == Move::differential && better) {
        differential_.succeeded(sizes_[static_cast<std::size_t>(k)]);
      }
    }
    differential_.learn();
  }

  // The cells of each colony, from best to worst.
  void gather_colonies() {
    const Eigen::Index most = std::max<Eigen::Index>(1, cells_.cols() / 4);
    // Without gradients no descent follows that would make use of several valleys.
    const int wanted = search_.objective().has_gradient() ? options_.colonies : 1;
    colonies_.resize(static_cast<std::size_t>(std::min<Eigen::Index>(wanted, most)));
    for (std::vector<Eigen::Index>& colony : colonies_) colony.clear();
    rank_anew(costs_, order_);
    for (const Eigen::Index i : order_) colony_of(i).push_back(i);
  }
  std::vector<Eigen::Index>& colony_of(Eigen::Index k) {
    return colonies_[static_cast<std::size_t>(k) % colonies_.size()];
  }

  // A step in 1 to 3 coordinates.
  void sparse(double size, Eigen::Ref<Point> point) {
    const Eigen::Index coordinates = 1 + pick(3);
    for (Eigen::Index n = 0; n < coordinates; ++n) {
      double& moved = point(pick(point.size()));
      moved = std::min(1.0, std::max(0.0, moved + size * search_.random.bell()));
    }
  }

  // Descents from the best cells that are apart, each with nothing known; then from elsewhere for
  // as long as there is budget, with the curvature of the one before: valleys resemble each other.
  void finish() {
    constexpr double apart = 0.1;
    // A descent along a narrow valley takes some two hundred evaluations a coordinate.
    share_of_descent_ = std::max<std::int64_t>(search_.left() * 2 / 5, 200 * search_.dimension());
    std::vector<Eigen::Index> used;
    // Differences cost 2 p evaluations a step: the rest is better spent on looking for other pits.
    const int wanted = search_.objective().has_gradient() ? options_.finishers : 1;
    double best = std::numeric_limits<double>::infinity();
    for (const Eigen::Index k : ranking(costs_)) {
      if (static_cast<int>(used.size()) >= wanted || search_.done()) break;
      bool near = false;
      for (const Eigen::Index other : used) {
        near = near || norm(cells_.col(k) - cells_.col(other)) < apart;
      }
      if (near) continue;
      used.push_back(k);
      descent_.forget();
      best = std::min(best, descend(k, cells_.col(k), best, 1, 0));
    }
    if (!search_.objective().has_gradient()) look_for_pits();
    while (search_.left() > 0 && !search_.done()) {
      // From 0.3 of the box down to 0.01 of it, in proportion as likely: their size hardly matters.
      const double size =
          roams() ? 0 : 0.3 * math<double>::exponential(uniform() * math<double>::log(0.03));
      const Point from = roams() ? far_point() : near_best(size);
      descend(ranking(costs_).back(), from, search_.result.cost, 2, size);
      if (search_.left() < 2 * search_.dimension()) spend_budget();
    }
  }

  // Looks along the coordinates and descends from where that leads, for as long as it leads on.
  void look_for_pits() {
    while (search_.left() > 0 && !search_.done()) {
      Point point = search_.box().to_unit(search_.result.x);
      if (!scan(point)) return;
      descent_.forget();
      descend(ranking(costs_).back(), point, search_.result.cost, 2, 1.0 / options_.scan_points);
    }
  }

  // Moves a point, along one coordinate after the other, to the best of points spread evenly over
  // the box, each anywhere in its part. False if it stays where it is.
  bool scan(Point& point) {
    const std::int64_t affordable = search_.left() / point.size();
    const auto count =
        static_cast<Eigen::Index>(std::min<std::int64_t>(options_.scan_points, affordable));
    bool moved = false;
    double cost = search_.result.cost;
    for (Eigen::Index i = 0; count > 0 && i < point.size() && !search_.done(); ++i) {
      Points along = point.replicate(1, count);
      for (Eigen::Index k = 0; k < count; ++k) {
        along(i, k) = (static_cast<double>(k) + uniform()) / static_cast<double>(count);
      }
      const Eigen::VectorXd costs = search_.evaluate(along);
      const Eigen::Index best = place_of_least(costs);
      if (!(costs(best) < cost)) continue;
      cost = costs(best);
      point = along.col(best);
      moved = true;
    }
    return moved;
  }

  // Whether other valleys are looked for: not where a start is known to be good, nor without
  // gradients, where a descent costs too much.
  bool looks_afar() const {
    return search_.objective().has_gradient() && search_.start.size() == 0;
  }
  // Whether descents start at random places, rather than by a jump off the best point.
  bool roams() const { return looks_afar() && options_.restart_points > 0; }

  // Descends from a point; cell k goes to where that ends, if it is better there.
  double descend(Eigen::Index k, Point point, double best, int phase, double size) {
    const auto note = [&] { search_.note(0, phase, round_++, cells_, costs_, size); };
    watch_.begin(best);
    const double cost = descent_.descend(point, share_of_descent_, [&](double now) {
      note();
      return !looks_afar() || watch_.is_promising(now);
    });
    keep(k, point, cost);
    note();
    return cost;
  }

  // The best of a few anywhere.
  Point far_point() {
    const std::int64_t affordable = std::max<std::int64_t>(1, search_.left());
    Points points(search_.dimension(), std::min<std::int64_t>(options_.restart_points, affordable));
    for (Eigen::Index k = 0; k < points.cols(); ++k) {
      points.col(k) = random_point(search_.random, search_.dimension());
    }
    return points.col(place_of_least(search_.evaluate_least(points, 1)));
  }

  Point near_best(double size) {
    Point point = search_.box().to_unit(search_.result.x);
    sparse(size, point);
    return point;
  }

  void keep(Eigen::Index k, const Point& point, double cost) {
    if (!(cost < costs_(k))) return;
    cells_.col(k) = point;
    costs_(k) = cost;
  }

  // The history ends with the result.
  void end_history() {
    const SearchResult& result = search_.result;
    if (result.reason == StopReason::not_a_number || result.evaluations == 0) return;
    if (!result.history.empty() && result.history.back().evaluations == result.evaluations) return;
    search_.note(0, 2, round_, cells_, costs_, 0);
  }

  // What is too little for a descent goes into sparse tumbles around the best point.
  void spend_budget() {
    while (search_.left() > 0 && !search_.done()) {
      search_.evaluate(near_best(1e-3));
    }
  }

  SearchSession& search_;
  BfoaPlusOptions options_;
  std::int64_t budget_;
  double differential_share_ = 0;
  QuasiNewton descent_{search_};
  DescentWatch watch_{options_.patience};
  std::int64_t share_of_descent_ = 0;
  int round_ = 0;
  Points cells_, headings_;
  Eigen::VectorXd costs_, steps_;
  std::vector<unsigned char> swimming_;
  DifferentialTumbles differential_;

  // Of the present chemotactic step; members, so that they are allocated once.
  std::vector<std::vector<Eigen::Index>> colonies_;
  std::vector<Eigen::Index> order_;  // of the cells, from best to worst
  Points places_;
  Eigen::VectorXd found_;  // their costs
  std::vector<Move> moves_;
  std::vector<DifferentialTumbles::Size> sizes_;  // of the differential ones
};

}  // namespace nfopidn
