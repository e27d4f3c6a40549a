// Passino's search step by step against an implementation of its own (tests/golden/README.md).
#include "nfopidn/search/bfoa.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

// Many minima; the least is at (0.3, 0.6, 0.9, ...).
class Hills : public Objective {
 public:
  explicit Hills(bool cheap) : cheap_(cheap) {}
  void costs(const Points& points, double* costs) override {
    for (Eigen::Index j = 0; j < points.cols(); ++j) costs[j] = height(points.col(j));
  }
  bool is_cheap() const override { return cheap_; }

 private:
  static double height(const Point& point) {
    double sum = 0;
    for (Eigen::Index i = 0; i < point.size(); ++i) {
      const double away = point(i) - 0.3 * static_cast<double>(i + 1);
      sum += away * away + 0.1 * std::cos(9 * point(i));
    }
    return sum;
  }
  bool cheap_;
};

struct Case {
  std::uint64_t seed;
  Eigen::Index dimension;
  BfoaOptions options;
};

// Those of tests/py/reference_bfoa.py.
std::vector<Case> golden_cases() {
  BfoaOptions brief;
  brief.chemotactic_steps = 6;
  brief.reproductions = 2;
  brief.dispersals = 3;
  std::vector<Case> cases = {{1, 2, brief},  {6, 4, brief},  {16, 3, brief},
                             {17, 3, brief}, {10, 2, brief}, {4, 2, brief}};
  cases[1].options.attractant_depth = 2.5;
  cases[1].options.attractant_width = 3;
  cases[1].options.repellent_height = 1.5;
  cases[1].options.repellent_width = 40;
  cases[2].options.dispersal_probability = 0.5;
  cases[2].options.cells = 6;
  cases[3].options.step = 0.4;
  cases[4].options.swims = 12;
  cases[4].options.step = 0.01;
  cases[4].options.attractant_depth = 0;
  cases[4].options.repellent_height = 1;
  cases[5].options.attractant_depth = 1;
  cases[5].options.repellent_height = 0;
  return cases;
}

SearchResult search(const Case& given, bool cheap) {
  Box box = {Point(given.dimension), Point(given.dimension), Point::Ones(given.dimension)};
  for (Eigen::Index i = 0; i < given.dimension; ++i) {
    box.low(i) = -1.0 - static_cast<double>(i);
    box.high(i) = 2.0 + 3 * static_cast<double>(i);
  }
  Hills hills(cheap);
  SearchSession search(hills, box, SearchLimits{}, given.seed);
  Bfoa(search, given.options).run();
  return search.result;
}

// eqs. 37-40
TEST(BfoaGolden, EveryStepIsTheReferences) {
  const CsvTable golden = read_golden_csv("bfoa.csv");
  const std::vector<Case> cases = golden_cases();
  for (const bool cheap : {false, true}) {
    std::size_t row = 0;
    for (std::size_t number = 0; number < cases.size(); ++number) {
      for (const HistoryRow& step : search(cases[number], cheap).history) {
        ASSERT_LT(row, golden.rows.size());
        const std::vector<double>& expected = golden.rows[row++];
        const double places[] = {static_cast<double>(number), static_cast<double>(step.dispersal),
                                 static_cast<double>(step.reproduction),
                                 static_cast<double>(step.chemotaxis),
                                 static_cast<double>(step.evaluations)};
        for (std::size_t i = 0; i < 5; ++i) ASSERT_EQ(places[i], expected[i]) << "row " << row;
        ASSERT_TRUE(near(step.best, expected[5], 1e-12)) << "row " << row;
        ASSERT_TRUE(near(step.mean, expected[6], 1e-12)) << "row " << row;
        ASSERT_EQ(step.step, cases[number].options.step);
      }
    }
    EXPECT_EQ(row, golden.rows.size());
  }
}

TEST(Exponentials, AreTheScalarOnesToTheLastBit) {
  std::vector<double> values = {0, -0.0, 1e-300, 700, -700, 1e4, -1e4};
  Random random(3);
  for (int i = 0; i < 1000; ++i) values.push_back(50 * random.normal());
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, values.size()}) {
    std::vector<double> powers(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
    exponentials(powers.data(), static_cast<std::ptrdiff_t>(count));
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(powers[i], math<double>::exponential(values[i])) << values[i];
    }
  }
}

TEST(BfoaGolden, RefusesOddCells) {
  BfoaOptions options;
  EXPECT_EQ(check_options(options).status, Status::ok);
  options.cells = 7;
  EXPECT_EQ(check_options(options).status, Status::inconsistent);
  options.cells = 0;
  EXPECT_EQ(check_options(options).status, Status::out_of_range);
}

}  // namespace
}  // namespace nfopidn::test
