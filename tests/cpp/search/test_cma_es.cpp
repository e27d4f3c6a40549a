// CMA-ES: its constants and its update against values and sums made without it, and what it owes to
// every search: budgets, bounds, resuming, ends.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <map>
#include <string>

#include "nfopidn/search/cma_es.hpp"

namespace nfopidn::test {
namespace {
namespace cma {

// The distance to 0.3 in every coordinate, more important from one to the next, and whether all
// points were in the box [-1, 2].
class Ellipsoid : public Objective {
 public:
  void costs(const Points& points, double* costs) override {
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      costs[j] = cost_of(points.col(j));
      EXPECT_TRUE(points.col(j).minCoeff() >= -1 && points.col(j).maxCoeff() <= 2);
    }
    asked += points.cols();
    blocks.push_back(points.cols());
  }
  virtual double cost_of(const Point& x) const {
    double sum = 0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      sum += (1 + 30 * static_cast<double>(i)) * (x(i) - 0.3) * (x(i) - 0.3);
    }
    return sum;
  }
  Eigen::Index asked = 0;
  std::vector<Eigen::Index> blocks;
};

class Constant : public Ellipsoid {
 public:
  explicit Constant(double cost) : cost_(cost) {}
  double cost_of(const Point& /*x*/) const override { return cost_; }

 private:
  double cost_;
};

// The least sum of the coordinates is at the lower corner, the greatest at the upper one.
class Slope : public Ellipsoid {
 public:
  explicit Slope(double sign) : sign_(sign) {}
  double cost_of(const Point& x) const override { return 10 + sign_ * x.sum(); }

 private:
  double sign_;
};

SearchLimits evaluations(std::int64_t count) {
  SearchLimits limits;
  limits.evaluations = count;
  return limits;
}

Box box(Eigen::Index n) { return {Point::Constant(n, -1), Point::Constant(n, 2), Point::Ones(n)}; }

SearchResult minimise(Objective& objective, const SearchLimits& limits,
                      const CmaEsOptions& options = {}, Eigen::Index n = 5,
                      std::uint64_t seed = 11) {
  SearchSession search(objective, box(n), limits, seed);
  CmaEs(search, options).run();
  return search.result;
}

void expect_same(const SearchResult& a, const SearchResult& b) {
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.evaluations, b.evaluations);
  EXPECT_EQ(a.population, b.population);
  ASSERT_EQ(a.history.size(), b.history.size());
  for (std::size_t i = 0; i < a.history.size(); ++i) {
    EXPECT_EQ(a.history[i].mean, b.history[i].mean);
    EXPECT_EQ(a.history[i].step, b.history[i].step);
    EXPECT_EQ(a.history[i].evaluations, b.history[i].evaluations);
  }
}

TEST(SymmetricEigen, Decomposes) {
  Random random(5);
  SymmetricEigen eigen;
  for (Eigen::Index n = 1; n <= 24; ++n) {
    for (const int kind : {0, 1, 2, 3, 4}) {
      Eigen::MatrixXd half(n, n);
      for (double& element : half.reshaped()) element = random.normal();
      if (kind == 1) half.rightCols(n / 2).setZero();  // many values of 0
      if (kind == 4) {
        for (Eigen::Index i = 0; i < n; ++i)
          half.row(i) *= std::pow(10, -6.0 * static_cast<double>(i) / static_cast<double>(n));
      }
      Eigen::MatrixXd matrix = half * half.transpose();
      if (kind == 2) matrix = Eigen::MatrixXd::Identity(n, n);
      if (kind == 3) matrix.setZero();
      eigen.decompose(matrix);
      const Eigen::MatrixXd& v = eigen.vectors();
      const double size = std::max(1e-300, matrix.norm());
      EXPECT_LT((v.transpose() * v - Eigen::MatrixXd::Identity(n, n)).norm(),
                1e-13 * static_cast<double>(n));
      EXPECT_LT((matrix * v - v * eigen.values().asDiagonal()).norm(), 1e-13 * size);
      Eigen::VectorXd values = eigen.values();
      std::sort(values.begin(), values.end());
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> other(matrix);
      EXPECT_LT((values - other.eigenvalues()).norm(), 1e-13 * size) << n << ' ' << kind;
    }
  }
}

// Those that pycma 4.5.0 has in es.sp after cma.CMAEvolutionStrategy(n * [0.5], 0.3, {"popsize":
// population}): the tutorial's. It sets the rates of the step size in another way.
TEST(CmaConstants, ArePycmas) {
  struct {
    Eigen::Index n, population, parents;
    double effective, rank_one, rank_mu, shape, first, last, sum;
  } const rows[] = {
      {2, 6, 3, 2.028611464610062, 0.1548153998964136, 0.08559277942666424, 0.6245545390268264,
       0.6370425712412168, -1.155981778158921, -1.207323654840602},
      {5, 8, 4, 2.60017882611318, 0.0472923041594009, 0.04785904960298248, 0.450199557992808,
       0.5299301844787792, -0.811149352026059, -0.988158029708424},
      {11, 11, 5, 3.41477208633761, 0.01292784943236166, 0.02270823289116273, 0.2759407429882342,
       0.4295440419866498, -0.4842590397470315, -0.5693023096214916},
      {11, 44, 22, 12.36867775304162, 0.01222055577778753, 0.1179864932736799, 0.2970879276918897,
       0.1554724428690621, -0.05383701513384531, 0.3298208612196646},
      {40, 15, 7, 4.540915209075957, 0.00116943272526184, 0.003405219643706347,
       0.093009216634249173, 0.3447961985920205, -0.3083672593205417, -0.3434235813314506}};
  for (const auto& row : rows) {
    const CmaConstants c(row.n, row.population);
    constexpr double share = 1e-13;
    EXPECT_EQ(c.parents, row.parents);
    EXPECT_NEAR(c.effective_parents, row.effective, share * row.effective);
    EXPECT_NEAR(c.rank_one_rate, row.rank_one, share);
    EXPECT_NEAR(c.rank_mu_rate, row.rank_mu, share);
    EXPECT_NEAR(c.shape_rate, row.shape, share);
    EXPECT_NEAR(c.weights(0), row.first, share);
    EXPECT_NEAR(c.weights(row.population - 1), row.last, share);
    EXPECT_NEAR(c.weights.sum(), row.sum, 10 * share);
    EXPECT_NEAR(c.weight_sum, row.sum, 10 * share);
  }
}

// The tutorial's equations as matrix products, in the order of its appendix A.
struct PlainUpdate {
  Point m;
  double sigma;
  Eigen::MatrixXd c;
  Point p_sigma, p_c;
  int g = 0;

  void learn(const CmaConstants& k, const Points& ranked) {
    const auto n = static_cast<double>(m.size());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(c);
    const Eigen::MatrixXd inverse_root = solver.operatorInverseSqrt();
    const Points y = (ranked.colwise() - m) / sigma;
    const Point step = y.leftCols(k.parents) * k.weights.head(k.parents);
    m += sigma * step;
    p_sigma =
        (1 - k.path_rate) * p_sigma +
        std::sqrt(k.path_rate * (2 - k.path_rate) * k.effective_parents) * (inverse_root * step);
    const double chi = std::sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
    const double start = std::pow(1 - k.path_rate, 2 * (++g));
    const bool h = p_sigma.norm() / std::sqrt(1 - start) < (1.4 + 2 / (n + 1)) * chi;
    stalls += h ? 0 : 1;
    p_c = (1 - k.shape_rate) * p_c;
    if (h) p_c += std::sqrt(k.shape_rate * (2 - k.shape_rate) * k.effective_parents) * step;
    Eigen::VectorXd w = k.weights;
    for (Eigen::Index i = 0; i < w.size(); ++i) {
      if (w(i) < 0) w(i) *= n / (inverse_root * y.col(i)).squaredNorm();
    }
    const double delta = h ? 0 : k.shape_rate * (2 - k.shape_rate);
    c = (1 + k.rank_one_rate * delta - k.rank_one_rate - k.rank_mu_rate * k.weights.sum()) * c +
        k.rank_one_rate * p_c * p_c.transpose() +
        k.rank_mu_rate * y * w.asDiagonal() * y.transpose();
    // Not by more than e, which the tutorial leaves open.
    sigma *= std::exp(std::min(1.0, k.path_rate / damping(k, n) * (p_sigma.norm() / chi - 1)));
  }
  static double damping(const CmaConstants& k, double n) {
    const double c_sigma = (k.effective_parents + 2) / (n + k.effective_parents + 5);
    EXPECT_NEAR(c_sigma, k.path_rate, 1e-15);
    return 1 + 2 * std::max(0.0, std::sqrt((k.effective_parents - 1) / (n + 1)) - 1) + c_sigma;
  }
  int stalls = 0;
};

// Points drawn from the distribution, stretched so that the paths are long or short, and ranked by
// a slope or a bowl.
void expect_plain_updates(Eigen::Index population, std::uint64_t seed, PlainUpdate& plain) {
  const Eigen::Index n = plain.m.size();
  const CmaConstants constants(n, population);
  Random random(seed);
  AdaptedNormal normal(constants, plain.m, plain.sigma);
  const double stretch = random.uniform(0.5, 3);
  for (int generation = 0; generation < 8; ++generation) {
    Points points(n, population);
    std::vector<std::pair<double, Eigen::Index>> costs;
    for (Eigen::Index k = 0; k < population; ++k) {
      normal.sample(random, points.col(k).data());
      points.col(k) = normal.mean() + stretch * (points.col(k) - normal.mean());
      costs.emplace_back(generation < 5 ? points(0, k) : points.col(k).squaredNorm(), k);
    }
    std::sort(costs.begin(), costs.end());
    std::vector<Eigen::Index> order;
    Points ranked(n, population);
    for (const auto& [cost, k] : costs) {
      ranked.col(static_cast<Eigen::Index>(order.size())) = points.col(k);
      order.push_back(k);
    }
    normal.learn(points, order);
    plain.learn(constants, ranked);
    const double size = plain.c.norm();
    ASSERT_LT((normal.mean() - plain.m).norm(), 1e-12 * (1 + plain.m.norm()));
    ASSERT_NEAR(normal.step(), plain.sigma, 1e-11 * plain.sigma);
    ASSERT_LT((normal.covariance() - plain.c).norm(), 1e-11 * size);
    ASSERT_LT((normal.path() - plain.p_sigma).norm(), 1e-10);
    ASSERT_LT((normal.shape_path() - plain.p_c).norm(), 1e-10);
    const Eigen::MatrixXd root = normal.axes() * normal.lengths().asDiagonal();
    ASSERT_LT((root * root.transpose() - plain.c).norm(), 1e-11 * size);
  }
}

TEST(AdaptedNormal, LearnsByTheTutorialsEquations) {
  int stalls = 0, steps = 0;
  for (const Eigen::Index population : {7, 20, 40}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Eigen::Index n = 3;
      PlainUpdate plain = {Point::Constant(n, 0.4), 0.3, Eigen::MatrixXd::Identity(n, n),
                           Point::Zero(n), Point::Zero(n)};
      expect_plain_updates(population, seed, plain);
      stalls += plain.stalls;
      steps += plain.g;
    }
  }
  EXPECT_GT(stalls, 0);  // h_sigma has had both values
  EXPECT_LT(stalls, steps);
}

TEST(AdaptedNormal, DrawsWithItsMeanAndCovariance) {
  const Eigen::Index n = 3;
  const CmaConstants constants(n, 8);
  AdaptedNormal normal(constants, Point::Constant(n, 0.4), 0.3);
  Random random(9);
  Points points(n, 8);
  std::vector<Eigen::Index> order(8);
  for (int generation = 0; generation < 10; ++generation) {  // of chance, so that C has a shape
    for (Eigen::Index k = 0; k < 8; ++k) {
      normal.sample(random, points.col(k).data());
      order[static_cast<std::size_t>(k)] = k;
    }
    normal.learn(points, order);
  }
  constexpr int count = 100000;
  Point sum = Point::Zero(n);
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < count; ++i) {
    Point point(n);
    normal.sample(random, point.data());
    point -= normal.mean();
    sum += point / count;
    squares += point * point.transpose() / count;
  }
  const Eigen::MatrixXd expected = normal.covariance() * normal.step() * normal.step();
  EXPECT_GT((expected / expected(0, 0) - Eigen::MatrixXd::Identity(n, n)).norm(), 0.2);
  EXPECT_LT((squares - expected).norm(), 0.02 * expected.norm());
  EXPECT_LT(sum.norm(), 0.02 * std::sqrt(expected.trace()));
}

TEST(CmaEs, MirrorsAtTheBounds) {
  EXPECT_EQ(CmaEs::mirrored(0.25), 0.25);
  EXPECT_EQ(CmaEs::mirrored(-0.25), 0.25);
  EXPECT_EQ(CmaEs::mirrored(1.25), 0.75);
  EXPECT_EQ(CmaEs::mirrored(2.25), 0.25);
  EXPECT_EQ(CmaEs::mirrored(-3.25), 0.75);
  EXPECT_EQ(CmaEs::mirrored(1), 1);
  EXPECT_EQ(CmaEs::mirrored(2), 0);
}

TEST(CmaEs, FindsTheBottomInAnyDimension) {
  for (const Eigen::Index n : {1, 2, 5, 20}) {
    Ellipsoid bowl;
    const SearchResult result = minimise(bowl, evaluations(20000), {}, n);
    EXPECT_LT(result.cost, 1e-18) << n;
    EXPECT_LT((result.x.array() - 0.3).abs().maxCoeff(), 1e-8) << n;
    EXPECT_EQ(result.evaluations, 20000);
  }
}

// Along a bent valley, where the axes must be learnt.
TEST(CmaEs, FollowsAValley) {
  class Valley : public Ellipsoid {
   public:
    double cost_of(const Point& x) const override {
      double cost = 0;
      for (Eigen::Index i = 0; i + 1 < x.size(); ++i) {
        const double off = x(i + 1) - x(i) * x(i), left = 1 - x(i);
        cost += 100 * off * off + left * left;
      }
      return cost;
    }
  } valley;
  const SearchResult result = minimise(valley, evaluations(6000));
  EXPECT_LT(result.cost, 1e-16);
  // The same bits on every processor.
  EXPECT_EQ(minimise(valley, evaluations(1000)).cost, 0x1.79552d29ea32cp-6);
}

TEST(CmaEs, FindsMinimaOnBounds) {
  for (const double sign : {-1.0, 1.0}) {
    Slope slope(sign);
    const SearchResult result = minimise(slope, evaluations(5000));
    EXPECT_NEAR(result.cost, 10 - (sign > 0 ? 5 : 10), 2e-3);
  }
}

TEST(CmaEs, HasTheSameHistoryForTheSameSeed) {
  Ellipsoid bowl;
  const SearchResult first = minimise(bowl, evaluations(1500));
  expect_same(minimise(bowl, evaluations(1500)), first);
  EXPECT_NE(minimise(bowl, evaluations(1500), {}, 5, 12).cost, first.cost);
}

// Whatever an objective takes at once.
TEST(CmaEs, IsTheSameInPieces) {
  class Pieces : public Ellipsoid {
   public:
    Eigen::Index most_at_once() const override { return 3; }
  } pieces;
  Ellipsoid bowl;
  expect_same(minimise(pieces, evaluations(1500)), minimise(bowl, evaluations(1500)));
  EXPECT_EQ(bowl.blocks.front(), 8);  // 4 + 3 ln 5, all at once
  EXPECT_EQ(pieces.blocks.front(), 3);
}

TEST(CmaEs, KeepsItsBudgetExactly) {
  for (const std::int64_t budget : {1, 7, 8, 9, 16, 333}) {
    Ellipsoid bowl;
    const SearchResult result = minimise(bowl, evaluations(budget));
    EXPECT_EQ(result.evaluations, budget);
    EXPECT_EQ(bowl.asked, budget);
    EXPECT_EQ(result.reason, StopReason::evaluations);
    ASSERT_FALSE(result.history.empty());
    EXPECT_EQ(result.history.size(), static_cast<std::size_t>((budget + 7) / 8));
    EXPECT_EQ(result.history.back().evaluations, budget);
    EXPECT_EQ(result.history.back().best, result.cost);
    EXPECT_TRUE(std::isfinite(result.history.back().mean));
    EXPECT_EQ(result.population.cols(), (budget - 1) % 8 + 1);
    EXPECT_EQ(result.population_costs.size(), result.population.cols());
  }
}

TEST(CmaEs, ResumesBitForBit) {
  Ellipsoid bowl;
  SearchSession whole(bowl, box(5), evaluations(1500), 5);
  CmaEs(whole, {}).run();
  for (const std::size_t cut : {std::size_t{0}, std::size_t{404}, std::size_t{1200}}) {
    Ellipsoid other;
    SearchSession search(other, box(5), evaluations(1500), 5);
    search.resume({whole.record().begin(), whole.record().begin() + static_cast<long>(cut)});
    CmaEs(search, {}).run();
    expect_same(search.result, whole.result);
    EXPECT_LE(other.asked, static_cast<Eigen::Index>(whole.record().size() - cut) + 8);
  }
}

TEST(CmaEs, StopsAtTheTargetAndWhenAsked) {
  Ellipsoid bowl;
  SearchLimits limits = evaluations(5000);
  limits.target = 0.5;
  const SearchResult result = minimise(bowl, limits);
  EXPECT_EQ(result.reason, StopReason::target);
  EXPECT_LE(result.cost, 0.5);
  EXPECT_EQ(result.history.back().evaluations, result.evaluations);

  SearchSession called(bowl, box(5), evaluations(5000), 1);
  int calls = 0;
  called.set_callback([&](const SearchResult&) { return ++calls < 3; });
  CmaEs(called, {}).run();
  EXPECT_EQ(called.result.reason, StopReason::callback);
  EXPECT_EQ(called.result.history.size(), 3U);

  Ellipsoid watched;
  SearchSession interrupted(watched, box(5), evaluations(5000), 1);
  interrupted.set_interruption([&] { return watched.asked >= 100; });
  CmaEs(interrupted, {}).run();
  EXPECT_EQ(interrupted.result.reason, StopReason::callback);
  EXPECT_EQ(interrupted.result.evaluations, 104);
}

TEST(CmaEs, StartsWhereItIsTold) {
  CmaEsOptions options;
  options.start_step = 1e-4;
  Ellipsoid bowl;
  SearchSession search(bowl, box(5), evaluations(8), 3);
  search.start = Point::Constant(5, 1.25);
  CmaEs(search, options).run();
  const double away = (search.result.population.array() - 1.25).abs().maxCoeff();
  EXPECT_GT(away, 0);
  EXPECT_LT(away, 3 * 5e-4);
  EXPECT_LT(search.result.history[0].step, 1.1e-4);
}

// A run ends where all costs are the same, and the next one, elsewhere, is larger.
TEST(CmaEs, RestartsWithALargerPopulation) {
  for (const double cost : {3.0, 0.0, std::numeric_limits<double>::infinity()}) {
    Constant flat(cost);
    const SearchResult result = minimise(flat, evaluations(3000));
    EXPECT_EQ(result.evaluations, 3000);
    EXPECT_EQ(result.cost, cost);
    EXPECT_TRUE(result.x.allFinite());
    EXPECT_GE(result.history.back().dispersal, 2);
    std::map<int, Eigen::Index> population;
    for (std::size_t i = 0; i + 1 < result.history.size(); ++i) {
      population[result.history[i].dispersal] = flat.blocks[i];
    }
    EXPECT_EQ(population[0], 8);
    EXPECT_EQ(population[1], 32);
    EXPECT_EQ(population[2], 128);
  }
}

// Where costs are chance, nothing gets better.
TEST(CmaEs, RestartsWhereNothingImproves) {
  class Noise : public Ellipsoid {
   public:
    double cost_of(const Point& x) const override {
      Random random(kernel::bit_cast<std::uint64_t>(x(0)));
      return 1 + random.uniform();
    }
  } noise;
  const SearchResult result = minimise(noise, evaluations(3000));
  EXPECT_GE(result.history.back().dispersal, 1);
}

// Where the squares of the axes differ by more than 1e14, rounding spoils the smaller ones.
TEST(CmaEs, RestartsWhereTheAxesAreTooUnlike) {
  class Needle : public Ellipsoid {
   public:
    double cost_of(const Point& x) const override {
      return 1e16 * (x(0) - 0.3) * (x(0) - 0.3) + (x(1) - 0.3) * (x(1) - 0.3);
    }
  } needle;
  CmaEsOptions options;
  options.tolerance = 0;
  const SearchResult result = minimise(needle, evaluations(20000), options, 2);
  double last_step = 0;
  for (const HistoryRow& row : result.history) {
    if (row.dispersal == 0) last_step = row.step;
  }
  EXPECT_GE(result.history.back().dispersal, 1);
  EXPECT_GT(last_step, 1e-6);  // not because it has become too fine
}

// Beyond, a cost would be all rounding.
TEST(CmaEs, RestartsWhereStepsAreTooFine) {
  Ellipsoid bowl;
  CmaEsOptions options;
  options.tolerance = 0;
  const SearchResult result = minimise(bowl, evaluations(20000), options);
  EXPECT_GE(result.history.back().dispersal, 1);
  for (const HistoryRow& row : result.history) EXPECT_GT(row.step, 1e-13);
}

// A start that is the worst point of all has no direction to learn from.
TEST(CmaEs, LeavesABadStart) {
  class Hill : public Ellipsoid {
   public:
    double cost_of(const Point& x) const override { return -(x.array() - 1.25).abs().sum(); }
  } hill;
  SearchSession search(hill, box(5), evaluations(800), 3);
  search.start = Point::Constant(5, 1.25);
  CmaEs(search, {}).run();
  EXPECT_EQ(search.result.history[10].dispersal, 0);
  EXPECT_LT(search.result.cost, -9);
}

TEST(CmaEs, StopsAtNaN) {
  Constant broken(std::numeric_limits<double>::quiet_NaN());
  const SearchResult result = minimise(broken, evaluations(500));
  EXPECT_EQ(result.reason, StopReason::not_a_number);
  EXPECT_EQ(result.evaluations, 1);
  EXPECT_TRUE(result.history.empty());
}

// Costs with steps and cliffs, of which some are infinite.
TEST(CmaEs, TakesInfiniteCostsAsTheWorst) {
  class Cliff : public Ellipsoid {
   public:
    double cost_of(const Point& x) const override {
      return x(0) > 0.5 ? std::numeric_limits<double>::infinity() : Ellipsoid::cost_of(x);
    }
  } cliff;
  EXPECT_LT(minimise(cliff, evaluations(5000)).cost, 1e-12);
}

TEST(CmaEs, EveryKnobTurnsSomething) {
  const std::map<std::string, double> other_values = {
      {"population", 20}, {"step", 0.1}, {"start_step", 0.3}, {"growth", 1.5}, {"tolerance", 1e-2}};
  const auto run = [](const CmaEsOptions& options) {
    Slope slope(1);
    SearchSession search(slope, box(3), evaluations(4000), 4);
    search.start = Point::Constant(3, 1);
    CmaEs(search, options).run();
    return search.result;
  };
  const SearchResult before = run({});
  EXPECT_GT(before.history.back().dispersal, 0);
  CmaEsOptions::fields([&](const auto& field) {
    ASSERT_EQ(other_values.count(field.name), 1U) << field.name;
    CmaEsOptions options;
    auto& member = options.*field.member;
    member = static_cast<std::decay_t<decltype(member)>>(other_values.at(field.name));
    EXPECT_NE(run(options).population_costs.sum(), before.population_costs.sum()) << field.name;
  });
}

TEST(CmaEs, RefusesAPopulationOfOne) {
  CmaEsOptions options;
  EXPECT_EQ(check_options(options).status, Status::ok);
  options.population = 1;
  EXPECT_EQ(check_options(options).status, Status::inconsistent);
  options.population = 2;
  EXPECT_EQ(check_options(options).status, Status::ok);
  Ellipsoid bowl;
  EXPECT_EQ(minimise(bowl, evaluations(501), options).evaluations, 501);
  options.population = -1;
  EXPECT_EQ(check_options(options).status, Status::out_of_range);
}

}  // namespace cma
}  // namespace
}  // namespace nfopidn::test
