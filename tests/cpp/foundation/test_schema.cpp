// Field lists, ranges and what they find.
#include <set>

#include "nfopidn/foundation/schema.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

struct Sample {
  double number = 1;
  int whole = 2;
  bool flag = false;
  double table[2][2] = {{0, 0}, {0, 0}};
  Allocation<double> allocation = Allocation<double>::paper();
  Form form = Form::positional;

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    visit(field("number", &Sample::number, "m", greater_than(0), "text", "option"));
    visit(field("whole", &Sample::whole, "", at_least(2), "text"));
    visit(field("flag", &Sample::flag, "", any_number(), "text"));
    visit(field("table", &Sample::table, "s", between(-1, 1), "text"));
    visit(field("allocation", &Sample::allocation, "", between(-2, 2), "text"));
    visit(field("form", &Sample::form, "", any_number(), "text"));
  }
};

TEST(Range, ContainsItsEndsUnlessTheyAreOpen) {
  EXPECT_TRUE(between(1, 2).contains(1.0));
  EXPECT_TRUE(between(1, 2).contains(2.0));
  EXPECT_FALSE(between(1, 2).contains(0.999));
  EXPECT_FALSE(between(1, 2).contains(2.001F));
  EXPECT_FALSE(greater_than(1).contains(1));
  EXPECT_TRUE(greater_than(1).contains(1.001));
  EXPECT_TRUE(at_least(1).contains(1));
  EXPECT_TRUE(at_least(1).contains(1e300));
  EXPECT_FALSE(at_least(1).contains(0));
  EXPECT_TRUE(any_number().contains(-1e300));
  const Range open = {0, 1, true, true};
  EXPECT_FALSE(open.contains(0.0));
  EXPECT_FALSE(open.contains(1.0));
  EXPECT_TRUE(open.contains(0.5));
  EXPECT_FALSE(between(1, 2).contains(not_a_number<double>));
}

TEST(RangeCheck, FindsTheFirstFieldThatBreaksItsRange) {
  const auto found = [](auto change) {
    Sample sample;
    change(sample);
    return check_ranges(sample);
  };
  EXPECT_EQ(found([](Sample&) {}).status, Status::ok);
  Finding finding = found([](Sample& s) { s.number = 0; });
  EXPECT_EQ(finding.status, Status::out_of_range);
  EXPECT_STREQ(finding.field, "number");
  EXPECT_EQ(finding.value, 0);
  EXPECT_TRUE(finding.range.low_open);
  finding = found([](Sample& s) { s.whole = 1; });
  EXPECT_STREQ(finding.field, "whole");
  EXPECT_EQ(finding.value, 1);
  finding = found([](Sample& s) { s.table[1][1] = -1.5; });
  EXPECT_EQ(finding.status, Status::out_of_range);
  EXPECT_STREQ(finding.field, "table");
  EXPECT_EQ(finding.value, -1.5);
  EXPECT_EQ(finding.range.low, -1);
  finding = found([](Sample& s) { s.allocation.matrix[0][2] = infinite<double>; });
  EXPECT_EQ(finding.status, Status::not_finite);
  EXPECT_STREQ(finding.field, "allocation");
  finding = found([](Sample& s) { s.table[0][1] = not_a_number<double>; });
  EXPECT_EQ(finding.status, Status::not_finite);
  finding = found([](Sample& s) { s.number = -1, s.whole = 0; });
  EXPECT_STREQ(finding.field, "number");
  EXPECT_EQ(finding.value, -1);
}

TEST(RangeCheck, WorksAtCompileTime) {
  static_assert(check_ranges(Sample{}).status == Status::ok);
  static_assert(ControllerSettings<float>{}.validate() == Status::ok);
}

template <class Settings>
void expect_tidy_fields() {
  std::set<std::string> names;
  std::set<std::string> options;
  Settings::fields([&](const auto& field) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
    EXPECT_TRUE(options.insert(field.name).second);
    if (field.option != nullptr) {
      EXPECT_TRUE(options.insert(field.option).second) << field.option;
    }
    EXPECT_GT(std::strlen(field.text), 5U) << field.name;
    EXPECT_EQ(std::strchr(field.text, '\n'), nullptr) << field.name;
    EXPECT_NE(field.unit, nullptr) << field.name;
  });
  EXPECT_GE(names.size(), 4U);
}

TEST(Schema, NamesOptionsAndTextsAreComplete) {
  expect_tidy_fields<ControllerSettings<double>>();
  expect_tidy_fields<ControllerSettings<float>>();
  expect_tidy_fields<Robot<double>>();
  expect_tidy_fields<TrajectorySettings>();
  expect_tidy_fields<Scenario>();
  expect_tidy_fields<Metrics>();
}

TEST(Schema, DefaultsAreInRange) {
  EXPECT_EQ(check_ranges(ControllerSettings<double>{}).status, Status::ok);
  EXPECT_EQ(check_ranges(TrajectorySettings{}).status, Status::ok);
  EXPECT_EQ(check_ranges(Robot<double>{}).status, Status::ok);
}

template <class Choice>
void expect_words(Choice last) {
  const auto& names = ChoiceNames<Choice>::names;
  EXPECT_EQ(std::size(names), static_cast<std::size_t>(last) + 1);
  EXPECT_EQ(std::set<std::string>(std::begin(names), std::end(names)).size(), std::size(names));
}

TEST(Schema, EveryChoiceHasItsWords) {
  expect_words(Generator::gl);
  expect_words(Form::incremental);
  expect_words(Activation::linear);
  expect_words(Frame::world);
  expect_words(Lateral::scheduled);
  expect_words(Net::speed_errors);
  expect_words(AntiWindup::clamp);
  expect_words(Integrator::exact);
  expect_words(Curve::samples);
  expect_words(HeadingChoice::continuous);
  expect_words(Derivatives::analytic);
  EXPECT_STREQ(ChoiceNames<Lateral>::names[static_cast<int>(Lateral::direction)], "direction");
  EXPECT_STREQ(ChoiceNames<Curve>::names[static_cast<int>(Curve::rounded_square)],
               "rounded_square");
}

TEST(StatusText, IsItsOwnForEach) {
  std::set<std::string> texts;
  for (const Status status : {Status::ok, Status::not_finite, Status::out_of_range,
                              Status::wrong_size, Status::not_a_choice, Status::inconsistent}) {
    EXPECT_TRUE(texts.insert(status_to_string(status)).second);
  }
  EXPECT_STREQ(status_to_string(Status::ok), "ok");
  EXPECT_STREQ(status_to_string(static_cast<Status>(99)), "unknown");
}

}  // namespace
}  // namespace nfopidn::test
