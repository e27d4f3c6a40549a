// L3. What a search for a minimum has in common, whatever its strategy: the budget, the best point
// so far, the history, and the record from which a search can be resumed.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "nfopidn/foundation/schema.hpp"
#include "nfopidn/math/ordered_sums.hpp"
#include "nfopidn/math/random.hpp"
#include "nfopidn/parallel/interruption.hpp"
#include "nfopidn/search/objective.hpp"
#include "nfopidn/search/ranking.hpp"

namespace nfopidn {

// Raised whenever a seed comes to lead a search elsewhere: a checkpoint's answers are to the
// questions of its own course.
constexpr int search_course = 2;

// A row a chemotactic step; of CMA-ES a row a generation, with the number of the restart as
// `dispersal` and that of the generation as `chemotaxis`.
struct HistoryRow {
  int dispersal;     // l
  int reproduction;  // k
  int chemotaxis;    // j
  std::int64_t evaluations;
  double best;  // so far
  double mean;  // of the cells
  double step;  // mean step, in units of the box
};

// Of a search that ends with its schedule.
constexpr std::int64_t unlimited_budget = std::int64_t{1} << 62;

enum class StopReason : unsigned char {
  schedule,     // the schedule is complete
  evaluations,  // the budget is used up
  time,
  target,        // a cost at or under the wanted one
  callback,      // asked to stop
  not_a_number,  // the objective returned NaN
};

struct SearchLimits {
  std::int64_t evaluations = std::numeric_limits<std::int64_t>::max();
  double seconds = std::numeric_limits<double>::infinity();
  double target = -std::numeric_limits<double>::infinity();
};

struct SearchResult {
  Point x;
  double cost = std::numeric_limits<double>::infinity();
  std::int64_t evaluations = 0;
  double seconds = 0;  // that it took, known at its end
  StopReason reason = StopReason::schedule;
  Points population;  // the cells
  Eigen::VectorXd population_costs;
  std::vector<HistoryRow> history;
};

// Evaluates points of the unit box within the limits, and remembers.
class SearchSession {
 public:
  // Called after each chemotactic step; returning false ends the search.
  using Callback = std::function<bool(const SearchResult&)>;

  SearchSession(Objective& objective, Box box, const SearchLimits& limits, std::uint64_t seed)
      : random(seed),
        objective_(objective),
        box_(std::move(box)),
        limits_(limits),
        start_(std::chrono::steady_clock::now()) {
    result.population.resize(dimension(), 0);
  }

  Random random;
  SearchResult result;
  // A point known to be good, in the objective's own units; empty if there is none.
  Point start;

  // Whether record() is kept, for a search that may be resumed.
  bool keeps_record = true;

  // What the objective has answered so far. Given to resume() of a search with the same settings,
  // it brings that search to the same place without asking the objective again.
  const std::vector<double>& record() const { return record_; }
  void resume(std::vector<double> record) { replay_ = std::move(record); }
  bool is_replaying() const { return answers_ < replay_.size(); }
  void set_callback(Callback callback) { callback_ = std::move(callback); }
  // Asked between two questions to the objective, once there is a first answer, and within long
  // ones; true ends the search, as a callback's false does.
  void set_interruption(std::function<bool()> interrupted) {
    interrupted_ = std::move(interrupted);
  }
  // Called after each answer of the objective, once it is in the record.
  void set_witness(std::function<void()> witness) { witness_ = std::move(witness); }
  // The objective's answers before now took this long [s], in an earlier process.
  void add_elapsed(double seconds) { earlier_ = seconds; }

  Eigen::Index dimension() const { return box_.dimension(); }
  const Box& box() const { return box_; }
  const Objective& objective() const { return objective_; }
  bool done() const { return done_; }
  std::int64_t left() const { return limits_.evaluations - result.evaluations; }
  double elapsed() const {
    const std::chrono::duration<double> now = std::chrono::steady_clock::now() - start_;
    return earlier_ + now.count();
  }

  // Costs of unit points; infinite for those that the budget no longer reaches.
  Eigen::VectorXd evaluate(const Eigen::Ref<const Points>& unit) {
    Eigen::VectorXd costs;
    evaluate(unit, costs);
    return costs;
  }
  // The same into `costs`, which keeps its memory where the size is the same. With `bounds`, what
  // costs more than its own of them has some cost over it.
  void evaluate(const Eigen::Ref<const Points>& unit, Eigen::VectorXd& costs,
                const Eigen::VectorXd* bounds = nullptr) {
    const auto asked = static_cast<Eigen::Index>(
        std::min<std::int64_t>(unit.cols(), std::max<std::int64_t>(left(), 0)));
    const Eigen::Index answered = ask(unit, costs, asked, true, bounds);
    for (Eigen::Index j = 0; j < unit.cols(); ++j) {
      if (j == answered) stop(answered < asked ? cut_short_ : StopReason::evaluations);
      if (j == answered || !count(unit.col(j), costs(j))) {
        costs.tail(unit.cols() - j).setConstant(std::numeric_limits<double>::infinity());
        break;
      }
    }
  }

  // Costs of unit points of which only the `wanted` least are of interest: the others have some
  // cost over these.
  Eigen::VectorXd evaluate_least(const Eigen::Ref<const Points>& unit, Eigen::Index wanted) {
    if (!objective_.is_cheap()) return evaluate(unit);
    constexpr Eigen::Index fewest = 8;  // with the widest instructions
    Eigen::VectorXd costs(unit.cols()), part;
    for (Eigen::Index first = 0; first < unit.cols(); first += part.size()) {
      const Eigen::Index most = std::max({wanted, fewest, first});
      const Eigen::Index size = std::min(most, unit.cols() - first);
      const bool bounded = first >= wanted;
      Eigen::VectorXd bounds;
      if (bounded) {
        Eigen::VectorXd known = costs.head(first);
        std::nth_element(known.begin(), known.begin() + (wanted - 1), known.end());
        bounds.setConstant(size, known(wanted - 1));
      }
      evaluate(unit.middleCols(first, size), part, bounded ? &bounds : nullptr);
      costs.segment(first, size) = part;
    }
    return costs;
  }

  // Costs without counting: for points that may turn out not to be wanted. count() those that are.
  // Where the search ends meanwhile, no more count.
  void preview(const Eigen::Ref<const Points>& unit, Eigen::VectorXd& costs) {
    if (ask(unit, costs, unit.cols(), false, nullptr) < unit.cols()) stop(cut_short_);
  }

  // Counts one evaluation. False, and nothing is counted, when the search is over.
  bool count(const Eigen::Ref<const Point>& unit, double cost) {
    if (done_) return false;
    if (left() <= 0) return stop(StopReason::evaluations);
    ++result.evaluations;
    if (std::isnan(cost)) return stop(StopReason::not_a_number);
    if (cost < result.cost || result.x.size() == 0) {
      result.cost = cost;
      result.x = box_.to_user(unit);
    }
    if (result.cost <= limits_.target) stop(StopReason::target);
    return true;
  }

  // The cost at a unit point and its slopes there, with respect to the unit box. False if the
  // budget does not reach.
  bool gradient(const Point& unit, double& cost, Point& slopes) {
    if (check_limits() || left() < 1 + dimension()) return false;
    std::vector<double> reply(static_cast<std::size_t>(1 + dimension()));
    const bool answered = answer(reply.data(), reply.size(),
                                 [&] { return differentiate(box_.to_user(unit), reply); });
    if (!answered || !count(unit, reply[0])) return false;
    result.evaluations += dimension();
    cost = reply[0];
    slopes =
        Eigen::Map<const Point>(reply.data() + 1, dimension()).cwiseProduct(box_.stretch(unit));
    return slopes.allFinite();
  }

  // Ends a search whose strategy would go on for as long as the budget lasts.
  void spend() {
    if (left() <= 0) stop(StopReason::evaluations);
  }

  // Ends a chemotactic step.
  void note(int dispersal, int reproduction, int chemotaxis, const Points& cells,
            const Eigen::VectorXd& costs, double step) {
    result.history.push_back(
        {dispersal, reproduction, chemotaxis, result.evaluations, result.cost, mean(costs), step});
    box_.to_user(cells, result.population);
    result.population_costs = costs;
    if (!done_ && callback_ && !callback_(result)) stop(StopReason::callback);
  }

 private:
  bool stop(StopReason reason) {
    if (!done_) result.reason = reason;
    done_ = true;
    return false;
  }

  bool check_limits() {
    if (left() <= 0) stop(StopReason::evaluations);
    // Whatever the time, there is a first point to show for it.
    if (!done_ && result.evaluations > 0 && is_cut_short()) stop(cut_short_);
    return done_;
  }

  // Whether the time is up, or somebody asks for an end. Either leaves a first answer a moment, so
  // that there mostly is one.
  bool is_cut_short() {
    constexpr double moment = 0.15;  // [s]
    const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - asked_at_;
    if (answers_ == 0 && waited.count() < moment) return false;
    if (is_late()) {
      cut_short_ = StopReason::time;
      return true;
    }
    cut_short_ = StopReason::callback;
    return interrupted_ && interrupted_();
  }

  // Not before all is there again that an earlier process had.
  bool is_late() const {
    return std::isfinite(limits_.seconds) && !is_replaying() && elapsed() >= limits_.seconds;
  }

  // Asks the objective; false if that was interrupted, which must end the search.
  template <class Ask>
  bool undisturbed(const Ask& ask) {
    if (answers_ == 0) asked_at_ = std::chrono::steady_clock::now();
    Interruption interruption([this] { return is_cut_short(); });
    ask();
    return !interruption.happened();
  }

  // Costs of the first `wanted` of unit points, infinite for the others; in pieces of what the
  // objective takes at once, and if `timed` for as long as there is time. Tells how many there are.
  Eigen::Index ask(const Eigen::Ref<const Points>& unit, Eigen::VectorXd& costs,
                   Eigen::Index wanted, bool timed, const Eigen::VectorXd* bounds) {
    costs.setConstant(unit.cols(), std::numeric_limits<double>::infinity());
    if (check_limits()) return 0;
    const Eigen::Index most = std::min(objective_.most_at_once(), wanted);
    Eigen::Index first = 0;
    for (; first < wanted && !(timed && first > 0 && is_cut_short()); first += most) {
      const Eigen::Index size = std::min(most, wanted - first);
      const auto question = [&] {
        box_.to_user(unit.middleCols(first, size), asked_);
        if (bounds == nullptr) {
          objective_.costs(asked_, costs.data() + first);
        } else {
          objective_.bounded_costs(asked_, bounds->data() + first, costs.data() + first);
        }
      };
      const bool answered = answer(costs.data() + first, static_cast<std::size_t>(size),
                                   [&] { return undisturbed(question); });
      if (answered) continue;
      costs.tail(unit.cols() - first).setConstant(std::numeric_limits<double>::infinity());
      return first;
    }
    return std::min(first, wanted);
  }

  // The cost and all slopes into `reply`; false if the search has ended before the last of them.
  bool differentiate(const Point& point, std::vector<double>& reply) {
    const Eigen::Index most = std::min(objective_.partials_at_once(), dimension());
    for (Eigen::Index first = 0; first < dimension(); first += most) {
      if (first > 0 && check_limits()) return false;
      const auto question = [&] {
        reply[0] = objective_.partials(point, first, std::min(most, dimension() - first),
                                       reply.data() + 1 + first);
      };
      if (!undisturbed(question)) return stop(cut_short_);
    }
    return true;
  }

  // Fills `count` numbers from the record of an earlier process, or asks; false if ask() is.
  template <class Ask>
  bool answer(double* numbers, std::size_t count, const Ask& ask) {
    if (answers_ + count <= replay_.size()) {
      std::copy_n(replay_.begin() + static_cast<std::ptrdiff_t>(answers_), count, numbers);
    } else {
      replay_.clear();
      if (!ask()) return false;
    }
    answers_ += count;
    if (keeps_record) record_.insert(record_.end(), numbers, numbers + count);
    if (witness_) witness_();
    return true;
  }

  Objective& objective_;
  Box box_;
  SearchLimits limits_;
  std::chrono::steady_clock::time_point start_;
  double earlier_ = 0;
  Callback callback_;
  std::function<bool()> interrupted_;
  std::function<void()> witness_;
  std::chrono::steady_clock::time_point asked_at_;  // the first question
  StopReason cut_short_ = StopReason::time;
  std::size_t answers_ = 0;
  std::vector<double> record_;
  std::vector<double> replay_;
  Points asked_;  // the points before the objective, in its own units
  bool done_ = false;
};

// Random points in the unit box.
inline Point random_point(Random& random, Eigen::Index dimension) {
  Point point(dimension);
  for (double& u : point) u = random.uniform();
  return point;
}

}  // namespace nfopidn
