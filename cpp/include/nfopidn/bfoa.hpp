// L3. Bacterial foraging as Passino published it (eqs. 37-40, steps 1-9).
#pragma once

#include "nfopidn/search.hpp"

namespace nfopidn {

// The paper's settings. Distances and steps are in units of the box.
struct BfoaOptions {
  int cells = 10;                       // S
  int chemotactic_steps = 14;           // N_c
  int swims = 5;                        // N_s
  int reproductions = 4;                // N_re
  int dispersals = 3;                   // N_ed
  double dispersal_probability = 0.25;  // P_ed
  double step = 0.05;                   // C
  double attractant_depth = 0.1;
  double attractant_width = 0.2;
  double repellent_height = 0.1;
  double repellent_width = 10;

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    using B = BfoaOptions;
    visit(field("cells", &B::cells, "", between(2, 10000), "cells S, an even number"));
    visit(field("chemotactic_steps", &B::chemotactic_steps, "", between(1, 1e6),
                "chemotactic steps N_c in a lifetime"));
    visit(field("swims", &B::swims, "", between(0, 1000), "most swims N_s after a tumble"));
    visit(field("reproductions", &B::reproductions, "", between(1, 1e6),
                "reproductions N_re between dispersals"));
    visit(field("dispersals", &B::dispersals, "", between(1, 1e6), "elimination-dispersals N_ed"));
    visit(field("dispersal_probability", &B::dispersal_probability, "", between(0, 1),
                "probability P_ed that a cell is dispersed"));
    visit(field("step", &B::step, "", between(0, 2), "step C, in units of the box"));
    visit(field("attractant_depth", &B::attractant_depth, "", between(0, 1e6),
                "depth of the attractant; 0 with repellent_height 0: no swarming"));
    visit(field("attractant_width", &B::attractant_width, "", between(0, 1e6),
                "width of the attractant"));
    visit(field("repellent_height", &B::repellent_height, "", between(0, 1e6),
                "height of the repellent"));
    visit(field("repellent_width", &B::repellent_width, "", between(0, 1e6),
                "width of the repellent"));
  }
};

// S/2 cells must be a whole number.
inline Finding check_options(const BfoaOptions& options) {
  const Finding finding = check_ranges(options);
  if (finding.status != Status::ok || options.cells % 2 == 0) return finding;
  return {Status::inconsistent, "cells", static_cast<double>(options.cells), between(2, 10000)};
}

class Bfoa {
 public:
  Bfoa(Search& search, const BfoaOptions& options) : search_(search), options_(options) {}

  void run() {
    const Eigen::Index p = search_.dimension();
    cells_.resize(p, options_.cells);
    for (Eigen::Index i = 0; i < cells_.cols(); ++i)
      cells_.col(i) = random_point(search_.random, p);
    costs_ = search_.evaluate(cells_);
    for (int l = 0; l < options_.dispersals && !search_.done(); ++l) {
      for (int k = 0; k < options_.reproductions && !search_.done(); ++k) {
        live(l, k);
        if (!search_.done()) reproduce();
      }
      if (!search_.done()) disperse();
    }
  }

 private:
  // A lifetime: N_c chemotactic steps. Health has a term a step, and the start's (eq. 40).
  void live(int l, int k) {
    crowding_ = swarm_all(cells_);
    health_ = costs_ + crowding_;
    for (int j = 0; j < options_.chemotactic_steps && !search_.done(); ++j) {
      const Points snapshot = cells_;
      step_all(snapshot);
      crowding_ = swarm_all(cells_);
      health_ += costs_ + crowding_;
      search_.note(l, k, j, cells_, costs_, options_.step);
    }
  }

  // Cells do not see each other move within a step, so they may move together: first every tumble,
  // then the swims of those that still improve.
  void step_all(const Points& snapshot) {
    const Points directions = tumble();
    Points ahead(cells_.rows(), cells_.cols() * (1 + options_.swims));
    Eigen::VectorXd known;
    if (search_.objective().is_cheap()) {
      for (Eigen::Index i = 0; i < cells_.cols(); ++i)
        ahead.col(i) = moved(cells_.col(i), directions.col(i));
      for (Eigen::Index place = cells_.cols(); place < ahead.cols(); ++place) {
        ahead.col(place) =
            moved(ahead.col(place - cells_.cols()), directions.col(place % cells_.cols()));
      }
      known = search_.look(ahead);
    }
    Eigen::VectorXd last = costs_ + crowding_;
    std::vector<Eigen::Index> swimming;
    for (Eigen::Index i = 0; i < cells_.cols(); ++i) swimming.push_back(i);
    for (int m = 0; m <= options_.swims && !swimming.empty() && !search_.done(); ++m) {
      move(swimming, directions, known, m);
      std::vector<Eigen::Index> improved;
      for (const Eigen::Index i : swimming) {
        const double now = costs_(i) + swarm(cells_.col(i), snapshot);
        if (!(now < last(i))) continue;
        last(i) = now;
        improved.push_back(i);
      }
      swimming = std::move(improved);
    }
  }

  // Moves the named cells one step ahead and evaluates them, or takes what was looked up.
  void move(const std::vector<Eigen::Index>& moving, const Points& directions,
            const Eigen::VectorXd& known, int m) {
    Points next(cells_.rows(), static_cast<Eigen::Index>(moving.size()));
    for (std::size_t n = 0; n < moving.size(); ++n) {
      next.col(static_cast<Eigen::Index>(n)) =
          moved(cells_.col(moving[n]), directions.col(moving[n]));
    }
    Eigen::VectorXd costs;
    if (known.size() == 0) costs = search_.evaluate(next);
    for (std::size_t n = 0; n < moving.size(); ++n) {
      const auto column = static_cast<Eigen::Index>(n);
      const double cost = known.size() == 0 ? costs(column) : known(m * cells_.cols() + moving[n]);
      if (known.size() != 0 && !search_.count(next.col(column), cost)) return;
      if (known.size() == 0 && search_.done() && std::isinf(cost)) continue;
      cells_.col(moving[n]) = next.col(column);
      costs_(moving[n]) = cost;
    }
  }

  using Column = Eigen::Ref<const Point>;

  Point moved(const Column& cell, const Column& direction) const {
    return clip_to_box(cell + options_.step * direction);
  }

  // A direction for each cell: uniform in [-1, 1]^p, then of length 1.
  Points tumble() {
    Points directions(cells_.rows(), cells_.cols());
    for (Eigen::Index i = 0; i < directions.cols(); ++i) {
      for (double& component : directions.col(i)) component = search_.random.uniform(-1, 1);
      const double length = directions.col(i).norm();
      if (length > 0) directions.col(i) /= length;
    }
    return directions;
  }

  // J_cc (eq. 38) of a cell among others at given places.
  double swarm(const Column& cell, const Points& others) const {
    using M = math<double>;
    if (options_.attractant_depth == 0 && options_.repellent_height == 0) return 0;
    double sum = 0;
    for (Eigen::Index i = 0; i < others.cols(); ++i) {
      const double square = (cell - others.col(i)).squaredNorm();
      sum += options_.repellent_height * M::exponential(-options_.repellent_width * square) -
             options_.attractant_depth * M::exponential(-options_.attractant_width * square);
    }
    return sum;
  }

  Eigen::VectorXd swarm_all(const Points& cells) const {
    Eigen::VectorXd values(cells.cols());
    for (Eigen::Index i = 0; i < cells.cols(); ++i) values(i) = swarm(cells.col(i), cells);
    return values;
  }

  // The healthier half splits, the other half dies.
  void reproduce() {
    const std::vector<Eigen::Index> order = ranking(health_);
    const std::size_t half = order.size() / 2;
    Points cells(cells_.rows(), cells_.cols());
    Eigen::VectorXd costs(costs_.size());
    for (std::size_t n = 0; n < order.size(); ++n) {
      cells.col(static_cast<Eigen::Index>(n)) = cells_.col(order[n % half]);
      costs(static_cast<Eigen::Index>(n)) = costs_(order[n % half]);
    }
    cells_ = cells;
    costs_ = costs;
  }

  void disperse() {
    std::vector<Eigen::Index> moved_cells;
    for (Eigen::Index i = 0; i < cells_.cols(); ++i) {
      if (search_.random.uniform() >= options_.dispersal_probability) continue;
      cells_.col(i) = random_point(search_.random, cells_.rows());
      moved_cells.push_back(i);
    }
    Points points(cells_.rows(), static_cast<Eigen::Index>(moved_cells.size()));
    for (std::size_t n = 0; n < moved_cells.size(); ++n) {
      points.col(static_cast<Eigen::Index>(n)) = cells_.col(moved_cells[n]);
    }
    if (moved_cells.empty()) return;
    const Eigen::VectorXd costs = search_.evaluate(points);
    for (std::size_t n = 0; n < moved_cells.size(); ++n) {
      costs_(moved_cells[n]) = costs(static_cast<Eigen::Index>(n));
    }
  }

  Search& search_;
  BfoaOptions options_;
  Points cells_;
  Eigen::VectorXd costs_, health_;
  Eigen::VectorXd crowding_;  // J_cc of each cell among all, where they are now
};

}  // namespace nfopidn
