// The searches: Passino's moves, budgets, resuming, and what they reach on known functions.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

#include "nfopidn/search/bfoa.hpp"
#include "nfopidn/search/bfoa_plus.hpp"

namespace nfopidn::test {
namespace {

// A function of each coordinate's distance from 0.3, with exact slopes on request.
class Bowl : public Objective {
 public:
  explicit Bowl(bool gradient = false, bool cheap = false) : gradient_(gradient), cheap_(cheap) {}
  void costs(const Points& points, double* costs) override {
    for (Eigen::Index j = 0; j < points.cols(); ++j) costs[j] = value(points.col(j));
    asked += points.cols();
  }
  bool has_gradient() const override { return gradient_; }
  bool is_cheap() const override { return cheap_; }
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override {
    for (Eigen::Index i = 0; i < count; ++i) slopes[i] = 2 * (point(first + i) - 0.3);
    return value(point);
  }
  Eigen::Index asked = 0;

 private:
  static double value(const Point& point) { return (point.array() - 0.3).square().sum(); }
  bool gradient_, cheap_;
};

// Gives up what is over its bound, and counts that.
class Impatient : public Bowl {
 public:
  explicit Impatient(bool cheap) : Bowl(false, cheap) {}
  void bounded_costs(const Points& points, const double* bounds, double* costs) override {
    Bowl::costs(points, costs);
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      if (costs[j] <= bounds[j]) continue;
      costs[j] = bounds[j] + 1;
      ++given_up;
    }
  }
  int given_up = 0;
};

// A bowl with many dents, so that where a search starts and jumps matters.
class Waves : public Objective {
 public:
  explicit Waves(bool gradient) : gradient_(gradient) {}
  void costs(const Points& points, double* costs) override {
    for (Eigen::Index j = 0; j < points.cols(); ++j) costs[j] = value(points.col(j));
  }
  bool has_gradient() const override { return gradient_; }
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override {
    for (Eigen::Index i = 0; i < count; ++i) {
      const double z = point(first + i) - 0.3;
      slopes[i] = 2 * z + 9 * std::sin(9 * z);
    }
    return value(point);
  }

 private:
  static double value(const Point& point) {
    const Eigen::ArrayXd z = point.array() - 0.3;
    return (z.square() + 1 - (9 * z).cos()).sum();
  }
  bool gradient_;
};

Box unit_box(Eigen::Index p) {
  return {Point::Constant(p, -1), Point::Constant(p, 2), Point::Ones(p)};
}

SearchLimits evaluations(std::int64_t count) {
  SearchLimits limits;
  limits.evaluations = count;
  return limits;
}

template <class Strategy, class... Rest>
SearchResult minimise(Objective& objective, const SearchLimits& limits, const Rest&... rest) {
  SearchSession search(objective, unit_box(5), limits, 11);
  Strategy(search, rest...).run();
  return search.result;
}

void expect_same(const SearchResult& a, const SearchResult& b) {
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.evaluations, b.evaluations);
  ASSERT_EQ(a.history.size(), b.history.size());
  for (std::size_t i = 0; i < a.history.size(); ++i) {
    EXPECT_EQ(a.history[i].mean, b.history[i].mean);
    EXPECT_EQ(a.history[i].evaluations, b.history[i].evaluations);
  }
}

TEST(SearchSession, EvaluatesOnlyTheLeastToTheirEnd) {
  const Eigen::Index p = 3;
  const Box box = {Point::Zero(p), Point::Ones(p), Point::Ones(p)};
  Random random(4);
  const Points points = latin_hypercube(random, p, 100);
  Bowl bowl;
  Eigen::VectorXd all(points.cols());
  bowl.costs(points, all.data());
  const std::vector<Eigen::Index> order = ranking(all);
  for (const bool cheap : {true, false}) {
    for (const Eigen::Index wanted : {1, 30, 100}) {
      Impatient impatient(cheap);
      SearchSession search(impatient, box, {1000}, 1);
      const Eigen::VectorXd costs = search.evaluate_least(points, wanted);
      const std::vector<Eigen::Index> found = ranking(costs);
      for (std::size_t k = 0; k < static_cast<std::size_t>(wanted); ++k) {
        EXPECT_EQ(found[k], order[k]);
        EXPECT_EQ(costs(found[k]), all(order[k]));
      }
      EXPECT_EQ(impatient.given_up > 0, cheap && wanted < 100);
      EXPECT_EQ(search.result.evaluations, 100);
      EXPECT_EQ(search.result.cost, all(order[0]));
    }
  }
  Impatient impatient(true);
  SearchSession search(impatient, box, {50}, 1);  // the budget ends on the way
  const Eigen::VectorXd costs = search.evaluate_least(points, 10);
  EXPECT_EQ(search.result.evaluations, 50);
  EXPECT_TRUE(costs.tail(50).array().isInf().all());
}

TEST(Bfoa, HasARowAChemotacticStep) {
  Bowl bowl;
  const SearchResult result = minimise<Bfoa>(bowl, SearchLimits{}, BfoaOptions{});
  EXPECT_EQ(result.history.size(), 3U * 4U * 14U);
  EXPECT_EQ(result.reason, StopReason::schedule);
  EXPECT_EQ(result.evaluations, bowl.asked);
  EXPECT_LT(result.cost, 0.3);
}

// Points looked up ahead change nothing, not even the count.
TEST(Bfoa, LookingAheadChangesNothing) {
  Bowl plain, cheap(false, true);
  expect_same(minimise<Bfoa>(plain, SearchLimits{}, BfoaOptions{}),
              minimise<Bfoa>(cheap, SearchLimits{}, BfoaOptions{}));
}

// Of every cell the tumble and the first swim: as half of them get no further, more were in vain.
TEST(Bfoa, LooksAheadByTwoMovesAtFirst) {
  class Blocks : public Bowl {
   public:
    Blocks() : Bowl(false, true) {}
    void costs(const Points& points, double* costs) override {
      Bowl::costs(points, costs);
      sizes.push_back(points.cols());
    }
    std::vector<Eigen::Index> sizes;
  } bowl;
  BfoaOptions options;
  options.cells = 6;
  minimise<Bfoa>(bowl, evaluations(500), options);
  ASSERT_GT(bowl.sizes.size(), 2U);
  EXPECT_EQ(bowl.sizes[0], 6);
  EXPECT_EQ(bowl.sizes[1], 12);
}

TEST(Bfoa, KeepsItsBudgetExactly) {
  for (const int budget : {1, 9, 10, 11, 64, 333}) {
    for (const bool cheap : {false, true}) {
      Bowl bowl(false, cheap);
      const SearchResult result = minimise<Bfoa>(bowl, evaluations(budget), BfoaOptions{});
      EXPECT_EQ(result.evaluations, budget);
      EXPECT_EQ(result.reason, StopReason::evaluations);
    }
  }
}

TEST(BfoaPlus, KeepsItsBudgetExactly) {
  for (const int budget : {1, 50, 333, 2000}) {
    for (const bool gradient : {false, true}) {
      Bowl bowl(gradient, true);
      const SearchResult result = minimise<BfoaPlus>(bowl, evaluations(budget), BfoaPlusOptions{},
                                                     static_cast<std::int64_t>(budget));
      EXPECT_EQ(result.evaluations, budget);
    }
  }
}

TEST(BfoaPlus, FindsTheBottom) {
  for (const bool gradient : {false, true}) {
    Bowl bowl(gradient, true);
    const SearchResult result =
        minimise<BfoaPlus>(bowl, evaluations(2000), BfoaPlusOptions{}, std::int64_t{2000});
    EXPECT_LT(result.cost, 1e-12);
    EXPECT_LT((result.x.array() - 0.3).abs().maxCoeff(), 1e-6);
  }
}

// On a lower bound too a bent box has slopes, those of differences.
TEST(Box, BendsWithASlopeEverywhere) {
  const Box box = {Point::Constant(1, -1), Point::Constant(1, 4), Point::Constant(1, 2)};
  for (const double u : {0.0, 0.2, 1.0}) {
    const Point unit = Point::Constant(1, u);
    EXPECT_NEAR(box.to_unit(box.to_user(unit))(0), u, 1e-14);
    const Point after = Point::Constant(1, u + 1e-6);
    const double slope = (box.to_user(after)(0, 0) - box.to_user(unit)(0, 0)) / 1e-6;
    EXPECT_NEAR(box.stretch(unit)(0), slope, 1e-4);
    EXPECT_GT(box.stretch(unit)(0), 0.1);
  }
  EXPECT_EQ(box.to_user(Points::Zero(1, 1))(0, 0), -1);
  EXPECT_EQ(box.to_user(Points::Ones(1, 1))(0, 0), 4);
}

TEST(QuasiNewton, LeavesALowerBoundOfABentBox) {
  Bowl bowl(true, true);
  const Box box = {Point::Zero(5), Point::Ones(5), Point::Constant(5, 2)};
  SearchSession search(bowl, box, evaluations(2000), 1);
  Point point = Point::Zero(5);
  const double cost = QuasiNewton(search).descend(point, 2000, [](double) { return true; });
  EXPECT_LT(cost, 1e-9);
}

TEST(DescentWatch, GivesUpTheSlow) {
  DescentWatch watch(10);
  watch.begin(0.5);
  for (int step = 0; step < 13; ++step) EXPECT_TRUE(watch.is_promising(1));
  EXPECT_FALSE(watch.is_promising(1));
  EXPECT_TRUE(watch.is_promising(0.5));
  // The pace counts, not the steps.
  watch.begin(0.5);
  for (int step = 0; step < 30; ++step) EXPECT_TRUE(watch.is_promising(10 - 0.2 * step));
}

// After the descents from the cells others start anywhere, but not where a start was given.
TEST(BfoaPlus, StartsAnewAnywhere) {
  class Watched : public Waves {
   public:
    Watched() : Waves(true) {}
    void costs(const Points& points, double* costs) override {
      Waves::costs(points, costs);
      spread = points.cols() == 40
                   ? (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).minCoeff()
                   : spread;
    }
    double spread = 0;  // of the last block of 40
  };
  for (const bool given : {false, true}) {
    Watched watched;
    SearchSession search(watched, unit_box(5), evaluations(10000), 3);
    if (given) search.start = Point::Constant(5, 0.3);
    BfoaPlusOptions options;
    options.cells = 30;
    BfoaPlus(search, options, 10000).run();
    if (given) {
      EXPECT_EQ(watched.spread, 0);
    } else {
      EXPECT_GT(watched.spread, 2.4);
    }
  }
}

TEST(SearchSession, StopsAtTheTargetAndWhenAsked) {
  Bowl bowl;
  SearchLimits limits;
  limits.target = 0.5;
  const SearchResult result = minimise<Bfoa>(bowl, limits, BfoaOptions{});
  EXPECT_EQ(result.reason, StopReason::target);
  EXPECT_LE(result.cost, 0.5);
  SearchSession search(bowl, unit_box(5), SearchLimits{}, 1);
  int calls = 0;
  search.set_callback([&](const SearchResult&) { return ++calls < 3; });
  Bfoa(search, BfoaOptions{}).run();
  EXPECT_EQ(search.result.reason, StopReason::callback);
  EXPECT_EQ(search.result.history.size(), 3U);
}

// A search fed with the record of another one's first part goes on as that would have.
TEST(SearchSession, ResumesBitForBit) {
  Bowl bowl;
  SearchSession whole(bowl, unit_box(5), evaluations(1500), 5);
  BfoaPlus(whole, BfoaPlusOptions{}, 1500).run();
  for (const std::size_t cut : {std::size_t{0}, std::size_t{400}, std::size_t{1200}}) {
    Bowl other;
    SearchSession search(other, unit_box(5), evaluations(1500), 5);
    search.resume({whole.record().begin(), whole.record().begin() + static_cast<long>(cut)});
    BfoaPlus(search, BfoaPlusOptions{}, 1500).run();
    expect_same(search.result, whole.result);
    EXPECT_LE(other.asked, static_cast<Eigen::Index>(whole.record().size() - cut) + 100);
  }
}

// What was found in time is not lost to the same time limit when it is found again.
TEST(SearchSession, HasNoTimeLimitWhileItRepeats) {
  Bowl bowl;
  SearchSession whole(bowl, unit_box(5), evaluations(1500), 5);
  BfoaPlus(whole, BfoaPlusOptions{}, 1500).run();
  SearchLimits limits = evaluations(1500);
  limits.seconds = 1;
  Bowl other;
  SearchSession search(other, unit_box(5), limits, 5);
  search.add_elapsed(2);
  search.resume({whole.record().begin(), whole.record().begin() + 1000});
  BfoaPlus(search, BfoaPlusOptions{}, 1500).run();
  EXPECT_EQ(search.result.reason, StopReason::time);
  EXPECT_GE(search.result.evaluations, 1000 - 64);
  EXPECT_LE(other.asked, 64);
}

// A witness sees every answer, in pieces no larger than the objective takes.
TEST(SearchSession, AsksInPieces) {
  class Pieces : public Bowl {
   public:
    Eigen::Index most_at_once() const override { return 7; }
  } pieces;
  Bowl bowl;
  SearchSession whole(bowl, unit_box(5), evaluations(500), 5),
      search(pieces, unit_box(5), evaluations(500), 5);
  std::size_t seen = 0;
  search.set_witness([&] {
    EXPECT_GT(search.record().size(), seen);
    EXPECT_LE(search.record().size(), seen + 7);
    seen = search.record().size();
  });
  BfoaPlus(whole, BfoaPlusOptions{}, 500).run();
  BfoaPlus(search, BfoaPlusOptions{}, 500).run();
  expect_same(search.result, whole.result);
  EXPECT_EQ(search.record(), whole.record());
  EXPECT_EQ(seen, whole.record().size());
}

// A bowl whose slopes are asked for few at a time.
class SlowBowl : public Bowl {
 public:
  explicit SlowBowl(Eigen::Index most) : Bowl(true, true), most_(most) {}
  Eigen::Index partials_at_once() const override { return most_; }
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override {
    ++askings;
    EXPECT_LE(count, most_);
    return Bowl::partials(point, first, count, slopes);
  }
  int askings = 0;

 private:
  Eigen::Index most_;
};

TEST(SearchSession, AsksForSlopesInPieces) {
  SlowBowl whole(1000), pieces(2);
  expect_same(minimise<BfoaPlus>(whole, evaluations(2000), BfoaPlusOptions{}, 2000),
              minimise<BfoaPlus>(pieces, evaluations(2000), BfoaPlusOptions{}, 2000));
  EXPECT_GT(whole.askings, 0);
  EXPECT_EQ(pieces.askings, 3 * whole.askings);  // of five slopes
}

// Between any two questions; what was asked for in part is neither counted nor recorded.
TEST(SearchSession, IsInterruptedWithinAGradient) {
  for (const int last : {1, 2, 3, 4, 14}) {
    SlowBowl bowl(2);
    SearchSession search(bowl, unit_box(5), evaluations(2000), 11);
    search.set_interruption([&] { return bowl.askings >= last; });
    BfoaPlus(search, {}, 2000).run();
    EXPECT_EQ(bowl.askings, last);
    EXPECT_EQ(search.result.reason, StopReason::callback);
    EXPECT_EQ(search.result.evaluations, static_cast<std::int64_t>(search.record().size()));
  }
  Bowl bowl(true, true);
  SearchSession search(bowl, unit_box(5), evaluations(2000), 11);
  search.set_interruption([] { return true; });
  BfoaPlus(search, {}, 2000).run();
  EXPECT_GT(search.result.evaluations, 0);  // there is something to show
  EXPECT_EQ(search.result.x.size(), 5);
}

// A block's answers before the interruption count.
TEST(SearchSession, IsInterruptedBetweenThePiecesOfABlock) {
  class OneByOne : public Bowl {
   public:
    Eigen::Index most_at_once() const override { return 1; }
  };
  for (const Eigen::Index last : {1, 2, 7, 23}) {
    OneByOne bowl;
    SearchSession search(bowl, unit_box(5), evaluations(500), 11);
    search.set_interruption([&] { return bowl.asked >= last; });
    BfoaPlus(search, {}, 500).run();
    EXPECT_EQ(bowl.asked, last);
    EXPECT_EQ(search.result.evaluations, last);
    EXPECT_EQ(search.result.reason, StopReason::callback);
  }
}

TEST(SearchSession, NeedsNoRecord) {
  Waves first(true), second(true);
  SearchSession kept(first, unit_box(5), evaluations(3000), 11);
  SearchSession bare(second, unit_box(5), evaluations(3000), 11);
  bare.keeps_record = false;
  BfoaPlus(kept, {}, 3000).run();
  BfoaPlus(bare, {}, 3000).run();
  expect_same(kept.result, bare.result);
  EXPECT_FALSE(kept.record().empty());
  EXPECT_TRUE(bare.record().empty());
}

// Of every dimension, whose remainders by two and by four are paths of their own.
TEST(SquaredDistances, AreSumsOfSquares) {
  Random random(3);
  for (Eigen::Index dimension = 1; dimension <= 17; ++dimension) {
    for (const Eigen::Index count : {1, 2, 5}) {
      Eigen::MatrixXd places(dimension, count);
      Point point(dimension);
      for (double& u : places.reshaped()) u = random.uniform();
      for (double& u : point) u = random.uniform();
      SquaredDistances distances;
      distances.set_places(places);
      std::vector<double> squares(static_cast<std::size_t>(count) + 1, -1);
      distances.of(point.data(), squares.data());
      for (Eigen::Index n = 0; n < count; ++n) {
        long double expected = 0;
        for (Eigen::Index i = 0; i < dimension; ++i) {
          const long double away = static_cast<long double>(point(i)) - places(i, n);
          expected += away * away;
        }
        EXPECT_NEAR(squares[static_cast<std::size_t>(n)], static_cast<double>(expected),
                    2e-15 * static_cast<double>(expected));
      }
      EXPECT_EQ(squares.back(), -1);
    }
  }
}

TEST(SearchSession, StopsAtNaN) {
  class Broken : public Objective {
   public:
    void costs(const Points& points, double* costs) override {
      for (Eigen::Index j = 0; j < points.cols(); ++j) costs[j] = std::nan("");
    }
  } broken;
  const SearchResult result = minimise<Bfoa>(broken, SearchLimits{}, BfoaOptions{});
  EXPECT_EQ(result.reason, StopReason::not_a_number);
}

// Every option changes the history.
template <class Options, class Run>
void expect_knobs(const Run& run, const std::map<std::string, double>& other_values,
                  const std::set<std::string>& without_say = {}) {
  const SearchResult before = run(Options{});
  Options::fields([&](const auto& field) {
    if (without_say.count(field.name) != 0) return;
    ASSERT_EQ(other_values.count(field.name), 1U) << field.name;
    Options options;
    auto& member = options.*field.member;
    member = static_cast<std::decay_t<decltype(member)>>(other_values.at(field.name));
    const SearchResult after = run(options);
    EXPECT_FALSE(after.cost == before.cost && after.evaluations == before.evaluations &&
                 after.population_costs.size() == before.population_costs.size() &&
                 after.population_costs == before.population_costs)
        << field.name;
  });
}

TEST(Bfoa, EveryKnobTurnsSomething) {
  expect_knobs<BfoaOptions>(
      [](const BfoaOptions& options) {
        Bowl bowl;
        return minimise<Bfoa>(bowl, SearchLimits{}, options);
      },
      {{"cells", 8},
       {"chemotactic_steps", 9},
       {"swims", 2},
       {"reproductions", 2},
       {"dispersals", 2},
       {"dispersal_probability", 0.9},
       {"step", 0.02},
       {"attractant_depth", 5},
       {"attractant_width", 9},
       {"repellent_height", 5},
       {"repellent_width", 0.1}});
}

// Along a bent valley descents take many steps. Without patience those from new places end early.
TEST(BfoaPlus, GivesUpSlowDescents) {
  class Valley : public Bowl {
   public:
    Valley() : Bowl(true, true) {}
    void costs(const Points& points, double* costs) override {
      for (Eigen::Index j = 0; j < points.cols(); ++j) costs[j] = at(points.col(j), nullptr);
    }
    double partials(const Point& point, Eigen::Index /*first*/, Eigen::Index /*count*/,
                    double* slopes) override {
      return at(point, slopes);
    }

   private:
    static double at(const Point& x, double* slopes) {
      if (slopes != nullptr) std::fill(slopes, slopes + x.size(), 0.0);
      double cost = 0;
      for (Eigen::Index i = 0; i + 1 < x.size(); ++i) {
        const double off = x(i + 1) - x(i) * x(i), left = 1 - x(i);
        cost += 100 * off * off + left * left;
        if (slopes == nullptr) continue;
        slopes[i] += -400 * off * x(i) - 2 * left;
        slopes[i + 1] += 200 * off;
      }
      return cost;
    }
  };
  std::size_t steps[2];
  for (const int patient : {0, 1}) {
    Valley valley;
    const Box box = {Point::Constant(5, -2), Point::Constant(5, 2), Point::Ones(5)};
    SearchSession search(valley, box, evaluations(4000), 1);
    BfoaPlusOptions options;
    options.patience = patient * 1e9;
    BfoaPlus(search, options, 4000).run();
    EXPECT_LT(search.result.cost, 1e-9);
    steps[patient] = search.result.history.size();
  }
  EXPECT_NE(steps[0], steps[1]);
}

TEST(Ranking, AnewIsThatOfCosts) {
  Random random(21);
  Eigen::VectorXd costs(40);
  for (double& cost : costs) cost = std::floor(10 * random.uniform());  // with ties
  std::vector<Eigen::Index> order = ranking(costs);
  for (std::size_t n = 1; n < order.size(); ++n) {
    const double before = costs(order[n - 1]), now = costs(order[n]);
    EXPECT_TRUE(before < now || (before == now && order[n - 1] < order[n])) << n;
  }
  for (int round = 0; round < 200; ++round) {
    const auto changed = static_cast<Eigen::Index>(40 * random.uniform());
    costs(changed) = round % 7 == 0 ? std::numeric_limits<double>::infinity()
                                    : std::floor(10 * random.uniform());
    rank_anew(costs, order);
    EXPECT_EQ(order, ranking(costs)) << round;
  }
}

TEST(LatinHypercube, HasAPointInEveryPartOfEveryCoordinate) {
  Random random(22);
  constexpr Eigen::Index count = 50;
  const Points points = latin_hypercube(random, 3, count);
  EXPECT_EQ(points.rows(), 3);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    std::set<int> parts;
    for (Eigen::Index k = 0; k < count; ++k) {
      EXPECT_TRUE(points(i, k) >= 0 && points(i, k) < 1);
      parts.insert(static_cast<int>(points(i, k) * count));
    }
    EXPECT_EQ(parts.size(), 50U);
  }
  EXPECT_NE(Point(points.row(0)), Point(points.row(1)));
}

// A bowl that is a thousand times as steep one way as another.
class Trough : public Bowl {
 public:
  Trough() : Bowl(true, true) {}
  void costs(const Points& points, double* costs) override {
    for (Eigen::Index j = 0; j < points.cols(); ++j) costs[j] = at(points.col(j), nullptr);
  }
  double partials(const Point& point, Eigen::Index /*first*/, Eigen::Index /*count*/,
                  double* slopes) override {
    ++asked;
    return at(point, slopes);
  }

 private:
  static double at(const Point& point, double* slopes) {
    double cost = 0, steepness = 1;
    for (Eigen::Index i = 0; i < point.size(); ++i, steepness *= 10) {
      const double off = point(i) - point((i + 1) % point.size()) / 2 - 0.3;
      cost += steepness * off * off;
    }
    for (Eigen::Index i = 0; slopes != nullptr && i < point.size(); ++i) slopes[i] = 0;
    steepness = 1;
    for (Eigen::Index i = 0; slopes != nullptr && i < point.size(); ++i, steepness *= 10) {
      const Eigen::Index next = (i + 1) % point.size();
      const double slope = 2 * steepness * (point(i) - point(next) / 2 - 0.3);
      slopes[i] += slope;
      slopes[next] -= slope / 2;
    }
    return cost;
  }
};

TEST(QuasiNewton, KeepsTheCurvatureUntilItIsToForget) {
  const auto gradients = [](bool forget) {
    Trough trough;
    SearchSession search(trough, unit_box(4), evaluations(100000), 1);
    QuasiNewton descent(search);
    Point first = Point::Constant(4, 0.9), second = Point::Constant(4, 0.1);
    EXPECT_LT(descent.descend(first, 20000, [](double) { return true; }), 1e-12);
    if (forget) descent.forget();
    const Eigen::Index before = trough.asked;
    EXPECT_LT(descent.descend(second, 20000, [](double) { return true; }), 1e-12);
    return trough.asked - before;
  };
  EXPECT_LT(gradients(false), gradients(true));
}

// Up to 64 cells, of 150 evaluations each or more, but never fewer than 4.
TEST(BfoaPlus, SmallBudgetsHaveFewCells) {
  for (const auto& [budget, cells] :
       std::map<std::int64_t, Eigen::Index>{{20000, 64}, {3000, 20}, {300, 4}}) {
    Waves waves(true);
    const SearchResult result =
        minimise<BfoaPlus>(waves, evaluations(budget), BfoaPlusOptions(), budget);
    EXPECT_EQ(result.population.cols(), cells) << budget;
  }
}

TEST(BfoaPlus, EveryKnobTurnsSomething) {
  std::map<std::string, double> values = {{"cells", 12},
                                          {"first_points", 60},
                                          {"differential_share", 0.2},
                                          {"colonies", 1},
                                          {"step", 0.01},
                                          {"foraging_share", 0.2},
                                          {"finishers", 1},
                                          {"restart_points", 0},
                                          {"evaluations_per_cell", 400},
                                          {"scan_points", 0},
                                          {"blind_differential_share", 0.2}};
  for (const bool gradient : {true, false}) {
    expect_knobs<BfoaPlusOptions>(
        [&](const BfoaPlusOptions& options) {
          Waves waves(gradient);
          return minimise<BfoaPlus>(waves, evaluations(3000), options, std::int64_t{3000});
        },
        values,
        gradient ? std::set<std::string>{"blind_foraging_share", "blind_cells",
                                         "blind_differential_share", "scan_points", "patience"}
                 : std::set<std::string>{"foraging_share", "cells", "colonies", "finishers",
                                         "differential_share", "restart_points", "patience",
                                         "evaluations_per_cell"});
    values.erase("foraging_share");
    values.erase("cells");
    values.erase("restart_points");
    values.erase("evaluations_per_cell");
    values["blind_foraging_share"] = 0.5;
    values["blind_cells"] = 12;
  }
}

}  // namespace
}  // namespace nfopidn::test
