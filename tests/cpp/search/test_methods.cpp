// What every method of search owes to its callers, for each of the list.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "nfopidn/io/json_method.hpp"

namespace nfopidn::test {
namespace {
namespace methods {

// A bowl with ripples around 0.3 in the box [-1, 2], with exact slopes on request.
class Ripples : public Objective {
 public:
  explicit Ripples(bool gradient = false) : gradient_(gradient) {}
  void costs(const Points& points, double* costs) override {
    for (Eigen::Index j = 0; j < points.cols(); ++j) costs[j] = cost_of(points.col(j));
    asked += points.cols();
  }
  bool has_gradient() const override { return gradient_; }
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override {
    for (Eigen::Index i = 0; i < count; ++i) {
      const double z = point(first + i) - 0.3;
      slopes[i] = 2 * z + 0.45 * std::sin(9 * z);
    }
    return cost_of(point);
  }
  Eigen::Index asked = 0;

 private:
  double cost_of(const Point& point) const {
    EXPECT_TRUE(point.minCoeff() >= -1 && point.maxCoeff() <= 2);
    double sum = 0;
    for (const double u : point) {
      const double z = u - 0.3;
      sum += z * z + 0.05 * (1 - std::cos(9 * z));
    }
    return sum;
  }
  bool gradient_;
};

template <class Given>
class Method : public ::testing::Test {
 public:
  static SearchLimits limits(std::int64_t evaluations) {
    SearchLimits result;
    result.evaluations = evaluations;
    return result;
  }
  static SearchSession make(Objective& objective, const SearchLimits& limits,
                            std::uint64_t seed = 7, Eigen::Index n = 4) {
    return {
        objective, {Point::Constant(n, -1), Point::Constant(n, 2), Point::Ones(n)}, limits, seed};
  }
  static void run(SearchSession& search) { Given(search, typename Given::Options{}).run(); }
  static void expect_same(const SearchResult& a, const SearchResult& b) {
    EXPECT_EQ(a.cost, b.cost);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.evaluations, b.evaluations);
    EXPECT_EQ(a.population, b.population);
    ASSERT_EQ(a.history.size(), b.history.size());
    for (std::size_t i = 0; i < a.history.size(); ++i) {
      EXPECT_EQ(a.history[i].evaluations, b.history[i].evaluations);
      EXPECT_EQ(a.history[i].mean, b.history[i].mean);
      EXPECT_EQ(a.history[i].step, b.history[i].step);
    }
  }
};

template <class List>
struct AsTypes;
template <class... Each>
struct AsTypes<std::tuple<Each...>> {
  using Types = ::testing::Types<Each...>;
};
TYPED_TEST_SUITE(Method, AsTypes<Methods>::Types);

TYPED_TEST(Method, IsFoundByItsName) {
  const std::optional<MethodOptions> found = method_named(TypeParam::name);
  ASSERT_TRUE(found.has_value());
  EXPECT_TRUE(std::holds_alternative<typename TypeParam::Options>(*found));
  EXPECT_STREQ(name_of(*found), TypeParam::name);
  EXPECT_EQ(default_budget(*found), TypeParam::default_budget);
  EXPECT_GE(TypeParam::default_budget, 1);
  EXPECT_EQ(check_options(typename TypeParam::Options{}).status, Status::ok);
}

// What JSON has been made of the defaults makes the defaults, and another value another option.
TYPED_TEST(Method, HasItsOptionsFromAndToJson) {
  MethodOptions options;
  ASSERT_TRUE(read_method(TypeParam::name, Json::object(), options));
  const Json defaults = write_options(options);
  EXPECT_FALSE(defaults.empty());
  ASSERT_TRUE(read_method(TypeParam::name, defaults, options));
  EXPECT_EQ(write_options(options), defaults);
  for (const auto& item : defaults.items()) {
    Json given = Json::object();
    given[item.key()] = "nonsense";
    const Outcome outcome = read_method(TypeParam::name, given, options);
    EXPECT_FALSE(outcome);
    EXPECT_NE(outcome.message.find(item.key()), std::string::npos) << outcome.message;
  }
  EXPECT_FALSE(read_method(TypeParam::name, Json{{"colour", 1}}, options));
}

TYPED_TEST(Method, RunsAsOneOfTheList) {
  Ripples one, other;
  SearchSession alone = this->make(one, this->limits(300)),
                listed = this->make(other, this->limits(300));
  this->run(alone);
  run_method(listed, *method_named(TypeParam::name));
  this->expect_same(alone.result, listed.result);
}

TYPED_TEST(Method, EndsWithoutALimitOnlyByASchedule) {
  Ripples ripples;
  SearchSession search = this->make(ripples, this->limits(TypeParam::default_budget));
  this->run(search);
  EXPECT_EQ(search.result.evaluations, ripples.asked);
  EXPECT_EQ(search.result.reason, TypeParam::default_budget == unlimited_budget
                                      ? StopReason::schedule
                                      : StopReason::evaluations);
  EXPECT_LT(search.result.cost, 0.2);
}

TYPED_TEST(Method, KeepsItsBudgetExactly) {
  for (const bool gradient : {false, true}) {
    for (const std::int64_t budget : {1, 5, 10, 11, 64, 333}) {
      Ripples ripples(gradient);
      SearchSession search = this->make(ripples, this->limits(budget));
      this->run(search);
      EXPECT_EQ(search.result.evaluations, budget);
      EXPECT_EQ(search.result.reason, StopReason::evaluations);
      EXPECT_TRUE(search.result.x.allFinite());
    }
  }
}

TYPED_TEST(Method, TakesOneDimension) {
  Ripples ripples;
  SearchSession search = this->make(ripples, this->limits(800), 7, 1);
  this->run(search);
  EXPECT_LT(search.result.cost, 1e-2);
}

TYPED_TEST(Method, HasTheSameHistoryForTheSameSeed) {
  Ripples ripples;
  SearchSession one = this->make(ripples, this->limits(600)),
                same = this->make(ripples, this->limits(600)),
                other = this->make(ripples, this->limits(600), 8);
  this->run(one);
  this->run(same);
  this->run(other);
  this->expect_same(one.result, same.result);
  EXPECT_NE(one.result.cost, other.result.cost);
}

TYPED_TEST(Method, TellsItsHistoryInOrder) {
  Ripples ripples;
  SearchSession search = this->make(ripples, this->limits(600));
  this->run(search);
  const std::vector<HistoryRow>& history = search.result.history;
  ASSERT_GT(history.size(), 1U);
  for (std::size_t i = 0; i < history.size(); ++i) {
    EXPECT_TRUE(history[i].best <= history[i].mean);
    EXPECT_GE(history[i].step, 0);
    if (i == 0) continue;
    EXPECT_LE(history[i - 1].evaluations, history[i].evaluations);
    EXPECT_GE(history[i - 1].best, history[i].best);
  }
  EXPECT_EQ(history.back().best, search.result.cost);
  EXPECT_EQ(search.result.population.cols(), search.result.population_costs.size());
}

TYPED_TEST(Method, ResumesBitForBit) {
  for (const bool gradient : {false, true}) {
    Ripples ripples(gradient);
    SearchSession whole = this->make(ripples, this->limits(900));
    this->run(whole);
    for (const std::size_t cut : {std::size_t{0}, std::size_t{200}, std::size_t{700}}) {
      Ripples other(gradient);
      SearchSession search = this->make(other, this->limits(900));
      search.resume({whole.record().begin(), whole.record().begin() + static_cast<long>(cut)});
      this->run(search);
      this->expect_same(search.result, whole.result);
      EXPECT_LE(other.asked, static_cast<Eigen::Index>(whole.record().size() - cut) + 300);
    }
  }
}

TYPED_TEST(Method, EndsWhenItIsAsked) {
  Ripples ripples;
  SearchLimits limits = this->limits(5000);
  limits.target = 0.3;
  SearchSession search = this->make(ripples, limits);
  this->run(search);
  EXPECT_EQ(search.result.reason, StopReason::target);
  EXPECT_LE(search.result.cost, 0.3);

  SearchSession called = this->make(ripples, this->limits(5000));
  int calls = 0;
  called.set_callback([&](const SearchResult&) { return ++calls < 3; });
  this->run(called);
  EXPECT_EQ(called.result.reason, StopReason::callback);
  EXPECT_EQ(calls, 3);
  EXPECT_GE(called.result.history.size(), 3U);

  SearchSession interrupted = this->make(ripples, this->limits(5000));
  interrupted.set_interruption([&] { return interrupted.result.evaluations >= 200; });
  this->run(interrupted);
  EXPECT_EQ(interrupted.result.reason, StopReason::callback);
  EXPECT_LT(interrupted.result.evaluations, 600);
}

TYPED_TEST(Method, IsNoWorseThanItsStart) {
  for (const std::int64_t budget : {1, 30, 300}) {
    Ripples ripples;
    SearchSession search = this->make(ripples, this->limits(budget));
    search.start = Point::Constant(4, 0.30001);
    this->run(search);
    EXPECT_LT(search.result.cost, 4 * 1.0001e-10 * (1 + 0.05 * 40.5)) << budget;
  }
}

TYPED_TEST(Method, StopsAtNaN) {
  class Broken : public Objective {
   public:
    void costs(const Points& points, double* costs) override {
      std::fill(costs, costs + points.cols(), std::numeric_limits<double>::quiet_NaN());
    }
  } broken;
  SearchSession search = this->make(broken, this->limits(500));
  this->run(search);
  EXPECT_EQ(search.result.reason, StopReason::not_a_number);
  EXPECT_EQ(search.result.evaluations, 1);
}

TEST(Methods, HaveNamesAndOptionsOfTheirOwn) {
  std::set<std::string> names;
  for_each_method([&](auto* method) { names.insert(MethodOf<decltype(method)>::name); });
  EXPECT_EQ(names.size(), std::tuple_size_v<Methods>);
  EXPECT_FALSE(method_named("").has_value());
  EXPECT_FALSE(method_named("bfo").has_value());
  EXPECT_STREQ(name_of({}), "bfoa+");
}

TEST(Methods, RefuseWhatTheyDoNotKnow) {
  MethodOptions options;
  EXPECT_EQ(read_method("simplex", Json::object(), options).message,
            "method is simplex; must be one of bfoa+, bfoa, cma");
  EXPECT_EQ(read_method("bfoa", Json{{"cells", 7}}, options).message,
            "cells is 7; must be an even number");
  EXPECT_EQ(read_method("cma", Json{{"population", 1}}, options).message,
            "population is 1; must be 0 or at least 2");
  EXPECT_EQ(read_method("cma", Json{{"step", 0}}, options).message,
            "step is 0; must be in [1e-09, 10]");
}

}  // namespace methods
}  // namespace
}  // namespace nfopidn::test
