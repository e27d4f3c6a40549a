// L3. Bacterial foraging as Passino published it (eqs. 37-40, steps 1-9).
#pragma once

#include "nfopidn/math/exponentials.hpp"
#include "nfopidn/math/ordered_sums.hpp"
#include "nfopidn/search/session.hpp"
#include "nfopidn/search/squared_distances.hpp"

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

inline const char* rule_of(const BfoaOptions& /*options*/) { return "an even number"; }

class Bfoa {
 public:
  using Options = BfoaOptions;
  static constexpr const char* name = "bfoa";
  static constexpr std::int64_t default_budget = unlimited_budget;

  Bfoa(SearchSession& search, const BfoaOptions& options) : search_(search), options_(options) {}

  void run() {
    const Eigen::Index p = search_.dimension();
    cells_.resize(p, options_.cells);
    for (Eigen::Index i = 0; i < cells_.cols(); ++i)
      cells_.col(i) = random_point(search_.random, p);
    if (search_.start.size() != 0) cells_.col(0) = search_.box().to_unit(search_.start);
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
    swarm_all();
    health_ = costs_ + crowding_;
    for (int j = 0; j < options_.chemotactic_steps && !search_.done(); ++j) {
      step_all();
      swarm_all();
      health_ += costs_ + crowding_;
      search_.note(l, k, j, cells_, costs_, options_.step);
    }
  }

  // Cells do not see each other move within a step, so they may move together: first every tumble,
  // then the swims of those that still improve.
  void step_all() {
    tumble();
    last_ = costs_ + crowding_;
    swimming_.clear();
    for (Eigen::Index i = 0; i < cells_.cols(); ++i) swimming_.push_back(i);
    looked_to_ = 0;
    for (int m = 0; m <= options_.swims && !swimming_.empty() && !search_.done(); ++m) {
      if (search_.objective().is_cheap()) {
        if (m == looked_to_) look_ahead(m);
        move_as_looked_up(m);
      } else {
        move();
      }
      std::size_t improved = 0;
      for (const Eigen::Index i : swimming_) {
        const double now = costs_(i) + swarm(cells_.col(i));
        if (!(now < last_(i))) continue;
        last_(i) = now;
        swimming_[improved++] = i;
      }
      swimming_.resize(improved);
    }
  }

  // Looks up the moves from the m-th on: of all cells the tumble and the first swim, as about half
  // of them get no further; of those that do, all the rest.
  void look_ahead(int m) {
    constexpr int first_moves = 2;
    const int moves = options_.swims + 1;
    looked_from_ = m;
    looked_to_ = m == 0 ? std::min(first_moves, moves) : moves;
    looked_ = static_cast<Eigen::Index>(swimming_.size());
    ahead_.resize(cells_.rows(), looked_ * (looked_to_ - m));
    place_.resize(static_cast<std::size_t>(cells_.cols()));
    for (Eigen::Index n = 0; n < looked_; ++n) {
      const Eigen::Index i = swimming_[static_cast<std::size_t>(n)];
      place_[static_cast<std::size_t>(i)] = n;
      move_ahead(cells_.col(i), i, ahead_.col(n));
      for (Eigen::Index column = n + looked_; column < ahead_.cols(); column += looked_) {
        move_ahead(ahead_.col(column - looked_), i, ahead_.col(column));
      }
    }
    search_.preview(ahead_, known_);
  }

  // Moves the swimming cells one step ahead, as looked up.
  void move_as_looked_up(int m) {
    for (const Eigen::Index i : swimming_) {
      const Eigen::Index column =
          (m - looked_from_) * looked_ + place_[static_cast<std::size_t>(i)];
      if (!search_.count(ahead_.col(column), known_(column))) return;
      cells_.col(i) = ahead_.col(column);
      costs_(i) = known_(column);
    }
  }

  // Moves the swimming cells one step ahead and evaluates them.
  void move() {
    ahead_.resize(cells_.rows(), static_cast<Eigen::Index>(swimming_.size()));
    for (std::size_t n = 0; n < swimming_.size(); ++n) {
      move_ahead(cells_.col(swimming_[n]), swimming_[n], ahead_.col(static_cast<Eigen::Index>(n)));
    }
    search_.evaluate(ahead_, known_);
    for (std::size_t n = 0; n < swimming_.size(); ++n) {
      const auto column = static_cast<Eigen::Index>(n);
      if (search_.done() && std::isinf(known_(column))) continue;
      cells_.col(swimming_[n]) = ahead_.col(column);
      costs_(swimming_[n]) = known_(column);
    }
  }

  using Column = Eigen::Ref<const Point>;

  // From a place, in the direction of cell i.
  void move_ahead(const Column& from, Eigen::Index i, Eigen::Ref<Point> to) const {
    to = clip_to_box(from + options_.step * directions_.col(i));
  }

  // A direction for each cell: uniform in [-1, 1]^p, then of length 1.
  void tumble() {
    directions_.resize(cells_.rows(), cells_.cols());
    for (Eigen::Index i = 0; i < directions_.cols(); ++i) {
      for (double& component : directions_.col(i)) component = search_.random.uniform(-1, 1);
      const double length = norm(directions_.col(i));
      if (length > 0) directions_.col(i) /= length;
    }
  }

  bool is_swarming() const {
    return options_.attractant_depth != 0 || options_.repellent_height != 0;
  }

  // J_cc (eq. 38) of a cell among all at the start of the chemotactic step.
  double swarm(const Column& cell) {
    if (!is_swarming()) return 0;
    attraction_.resize(cells_.cols());
    distances_.of(cell.data(), attraction_.data());
    signals();
    double sum = 0;
    for (Eigen::Index i = 0; i < attraction_.size(); ++i) sum += repulsion_(i) - attraction_(i);
    return sum;
  }

  // Of squared distances in attraction_ makes both signals.
  void signals() {
    repulsion_ = -options_.repellent_width * attraction_;
    attraction_ *= -options_.attractant_width;
    exponentials(repulsion_.data(), repulsion_.size());
    exponentials(attraction_.data(), attraction_.size());
    repulsion_ *= options_.repellent_height;
    attraction_ *= options_.attractant_depth;
  }

  // J_cc of every cell among all, where they are now: their places at the start of the next
  // chemotactic step too. A pair's signals are the same from either side.
  void swarm_all() {
    const Eigen::Index count = cells_.cols();
    crowding_ = Eigen::VectorXd::Zero(count);
    if (!is_swarming()) return;
    attraction_.resize(count * (count + 1) / 2);
    distances_.set_places(cells_);
    row_.resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      distances_.of(cells_.col(i).data(), row_.data());
      attraction_.segment(i * (i + 1) / 2, i + 1) = row_.head(i + 1);
    }
    signals();
    for (Eigen::Index i = 0; i < count; ++i) {
      for (Eigen::Index k = 0; k < count; ++k) {
        const Eigen::Index later = std::max(i, k);
        const Eigen::Index place = later * (later + 1) / 2 + std::min(i, k);
        crowding_(i) += repulsion_(place) - attraction_(place);
      }
    }
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

  SearchSession& search_;
  BfoaOptions options_;
  Points cells_;
  Eigen::VectorXd costs_, health_;
  Eigen::VectorXd crowding_;  // J_cc of each cell among all, where they are now

  // Of the present chemotactic step; members, so that they are allocated once.
  Points directions_;
  Eigen::VectorXd last_;                // the cost with J_cc that a cell's swim has to beat
  std::vector<Eigen::Index> swimming_;  // the cells that still move
  Points ahead_;           // moves looked_from_ .. looked_to_ - 1 of looked_ cells, move by move
  Eigen::VectorXd known_;  // their costs
  std::vector<Eigen::Index> place_;  // of each cell among the looked_
  Eigen::Index looked_ = 0;
  int looked_from_ = 0;
  int looked_to_ = 0;
  SquaredDistances distances_;  // to the cells at the start of the step
  Eigen::VectorXd attraction_, repulsion_, row_;
};

}  // namespace nfopidn
