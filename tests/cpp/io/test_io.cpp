// Reading and writing: what the executable's and Python's tests of files do not come by.
#include <set>

#include "nfopidn/io/csv.hpp"
#include "nfopidn/io/file_lock.hpp"
#include "nfopidn/io/json_rival.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

namespace fs = std::filesystem;

class Files : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder);
    fs::create_directory(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  static std::string content(const fs::path& path) {
    std::string text;
    EXPECT_TRUE(read_file(path.string(), text)) << path;
    return text;
  }
  std::ptrdiff_t count() const {
    return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
  }

  const fs::path folder =
      fs::temp_directory_path() / ("nfopidn-test-io-" + std::to_string(::getpid()));
};

TEST_F(Files, AreReplacedWhole) {
  const fs::path path = folder / "a.txt";
  ASSERT_TRUE(write_file(path.string(), "old"));
  ASSERT_TRUE(write_file(path.string(), "new"));
  EXPECT_EQ(content(path), "new");
  EXPECT_EQ(count(), 1);
}

// Nothing lies about while a long run goes on, which may be killed.
TEST_F(Files, AreTriedWithoutATrace) {
  const fs::path path = folder / "a.txt";
  EXPECT_TRUE(check_writable(path.string()));
  EXPECT_EQ(count(), 0);
  ASSERT_TRUE(write_file(path.string(), "old"));
  EXPECT_TRUE(check_writable(path.string()));
  EXPECT_EQ(content(path), "old");
  EXPECT_EQ(count(), 1);
}

TEST_F(Files, WhatCannotBeWrittenShowsBefore) {
  fs::create_symlink("loop", folder / "loop");
  const std::string names[] = {folder.string(), (folder / "loop").string(),
                               (folder / "none" / "a").string(),
                               (folder / std::string(250, 'a')).string(), "/dev/fd/987"};
  for (const std::string& name : names) {
    const std::string message = check_writable(name).message;
    EXPECT_EQ(message.find(name + ": cannot be written: "), 0U) << message;
    EXPECT_EQ(write_file(name, "text").message, message);
  }
  EXPECT_EQ(count(), 1);
}

TEST_F(Files, AnOpenOneIsWrittenOn) {
  const fs::path path = folder / "log", link = folder / "link";
  ASSERT_TRUE(write_file(path.string(), "before "));
  std::FILE* const log = std::fopen(path.c_str(), "ab");
  ASSERT_NE(log, nullptr);
  const std::string number = std::to_string(::fileno(log));
  fs::create_symlink("/dev/fd/" + number, link);
  const std::string names[] = {"/dev/fd/" + number, "/proc/self/fd/" + number, link.string()};
  for (const std::string& name : names) {
    EXPECT_EQ(descriptor_of(name), ::fileno(log)) << name;
    ASSERT_TRUE(write_file(name, "more ")) << name;
  }
  std::fputs("after", log);
  std::fclose(log);
  EXPECT_EQ(content(path), "before more more more after");
  EXPECT_EQ(count(), 2);
  // Closed, it cannot be.
  EXPECT_NE(write_file("/dev/fd/" + number, "more").message.find("cannot be written"),
            std::string::npos);
  EXPECT_EQ(descriptor_of(path.string()), -1);
  EXPECT_EQ(descriptor_of((folder / "none" / "file").string()), -1);
  EXPECT_EQ(descriptor_of(""), -1);
  EXPECT_EQ(descriptor_of("/dev/fd/three"), -1);
}

TEST_F(Files, ALinkStaysALink) {
  const fs::path path = folder / "a.txt", link = folder / "link";
  ASSERT_TRUE(write_file(path.string(), "old"));
  fs::create_symlink("a.txt", link);
  ASSERT_TRUE(write_file(link.string(), "new"));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(content(path), "new");
  // One that points nowhere is replaced.
  fs::remove(path);
  ASSERT_TRUE(write_file(link.string(), "newer"));
  EXPECT_EQ(content(link), "newer");
  EXPECT_EQ(count(), 1);
}

TEST_F(Files, InUtf16AreCalledWhatTheyAre) {
  const std::string path = (folder / "a.csv").string();
  for (const std::string mark : {"\xFF\xFE", "\xFE\xFF"}) {
    ASSERT_TRUE(write_file(path, mark + std::string("x\0,\0y\0", 6)));
    std::string text;
    EXPECT_EQ(read_file(path, text).message,
              path + ": is text in UTF-16, as some spreadsheets write it; must be in UTF-8");
  }
}

TEST_F(Files, WithoutAnEndAreNotRead) {
  std::string text;
  const Outcome endless = read_file("/dev/zero", text);
  EXPECT_EQ(endless.status, Status::not_a_choice);
  EXPECT_EQ(endless.message, "/dev/zero: holds a byte 0; must be text in UTF-8");
  const fs::path path = folder / "a.txt";
  const std::string hundred(100, 'a');
  ASSERT_TRUE(write_file(path.string(), hundred));
  EXPECT_TRUE(read_file(path.string(), text, 100));
  EXPECT_EQ(text, hundred);
  const Outcome large = read_file(path.string(), text, 99);
  EXPECT_EQ(large.status, Status::out_of_range);
  EXPECT_EQ(large.message, path.string() + ": is larger than 99 bytes, the most that is read");
}

// Also where a file of the next name lies about, of another process of the same number perhaps.
TEST_F(Files, DraftsHaveNamesOfTheirOwn) {
  const fs::path path = folder / "a.txt";
  std::set<std::string> drafts;
  for (int i = 0; i < 4; ++i) {
    OutputTarget target;
    ASSERT_TRUE(find_target(path.string(), target));
    std::FILE* const file = target.open();
    ASSERT_NE(file, nullptr);
    std::fclose(file);
    EXPECT_TRUE(drafts.insert(target.draft).second);
    const std::size_t number = target.draft.rfind('-') + 1;
    const int next = std::stoi(target.draft.substr(number)) + 1;
    std::ofstream(target.draft.substr(0, number) + std::to_string(next)) << "another's";
  }
  EXPECT_EQ(count(), 8);
}

TEST_F(Files, AreKeptUnderAnotherName) {
  const fs::path path = folder / "a.txt", before = folder / "b.txt";
  for (const char* text : {"one", "two", "three"}) {
    ASSERT_TRUE(write_file(path.string(), text, before.string()));
  }
  EXPECT_EQ(content(path), "three");
  EXPECT_EQ(content(before), "two");
  EXPECT_EQ(count(), 2);
}

TEST_F(Files, AreLockedOnce) {
  const fs::path path = folder / "a.txt";
  FileLock first, second;
  ASSERT_TRUE(first.take(path.string()));
  EXPECT_TRUE(fs::exists(path.string() + ".lock"));
  EXPECT_NE(second.take((folder / "." / "a.txt").string()).message.find("another thread"),
            std::string::npos);
  first.release();
  EXPECT_FALSE(fs::exists(path.string() + ".lock"));
  EXPECT_TRUE(second.take(path.string()));
}

TEST_F(Files, WhatCannotBeReplacedIsSaid) {
  const fs::path path = folder / "a";
  ASSERT_TRUE(check_writable(path.string()));
  fs::create_directories(path / "b");
  const Outcome outcome = write_file(path.string(), "text");
  EXPECT_EQ(outcome.status, Status::inconsistent);
  EXPECT_NE(outcome.message.find("cannot be written"), std::string::npos);
  EXPECT_EQ(count(), 1);
}

TEST(Printable, TakesUtf8AndNothingElse) {
  EXPECT_EQ(printable("a\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80"),
            "a\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80");
  EXPECT_EQ(printable("\n\x7F"), "\\x0a\\x7f");
  EXPECT_EQ(printable("\xC3"), "\\xc3");             // cut off
  EXPECT_EQ(printable("\xE2\x82z"), "\\xe2\\x82z");  // broken off
  EXPECT_EQ(printable("\xC0\x80\xFF"), "\\xc0\\x80\\xff");
}

TEST(RangeText, NamesWhatIsBounded) {
  EXPECT_EQ(range_text(between(1, 2)), "in [1, 2]");
  EXPECT_EQ(range_text({1, 2, true, true}), "in (1, 2)");
  EXPECT_EQ(range_text(greater_than(0)), "greater than 0");
  EXPECT_EQ(range_text(at_least(0.5)), "at least 0.5");
  EXPECT_EQ(range_text({-infinite<double>, 3, false, true}), "less than 3");
  EXPECT_EQ(range_text({-infinite<double>, 3, false, false}), "at most 3");
  EXPECT_EQ(range_text(any_number()), "finite");
}

Outcome read_taps_document(const Json& extra) {
  Json document = {{"format", controller_format}, {"version", 1}};
  document.update(extra);
  ControllerDesign design;
  Outcome outcome = read_controller(document, design);
  EXPECT_EQ(write_controller(design), write_controller(ControllerDesign()));
  return outcome;
}

TEST(TapsDocument, IsRefusedWithItsReason) {
  const Json rows = Json::array({{1, 2}, {3, 4}, {5, 6}});
  EXPECT_EQ(read_taps_document({{"taps", {{1, 2}, {3, 4}}}}).message,
            "taps must be 3 lists of 2 to 1026 numbers, all of one length");
  EXPECT_EQ(read_taps_document({{"taps", {{1, 2}, {3, 4}, {5, 6, 7}}}}).status, Status::wrong_size);
  EXPECT_EQ(read_taps_document({{"taps", rows}, {"memory", 3}}).message,
            "memory is 3; 2 taps a channel make it 0");
  EXPECT_EQ(read_taps_document({{"taps", rows}, {"alpha", 0.5}}).message,
            "alpha stands beside taps; leave out one");
  EXPECT_EQ(read_taps_document({{"taps", {{1, 2}, {3, 1e7}, {5, 6}}}}).status,
            Status::out_of_range);
}

TEST(Documents, OrdersThatHaveNoModesAreRefusedWithALongMemory) {
  const auto refusal = [](const Json& extra) {
    Json document = {{"format", controller_format}, {"version", 1}, {"memory", 2000}};
    document.update(extra);
    ControllerDesign design;
    return read_controller(document, design).message;
  };
  EXPECT_EQ(refusal({{"alpha", 0.5}, {"sigma", 0.5}}), "");
  EXPECT_EQ(refusal({{"alpha", 1}, {"sigma", 0.5}}),
            "alpha is 1; must be in (-1, 1) with a memory beyond 1024");
  EXPECT_EQ(refusal({{"alpha", 0.5}, {"sigma", 2}}),
            "sigma is 2; must be in (0, 2) with a memory beyond 1024");
}

TEST(Documents, PartsOfTheTrackingLawThatContradictAnotherSettingAreRefusedByTheirNames) {
  const auto refusal = [](const Json& extra) {
    Json document = {{"format", controller_format}, {"version", 2}};
    document.update(extra);
    ControllerDesign design;
    return read_controller(document, design).message;
  };
  const Json proportional = {{1, 0, 0}, {1, 1, 1}, {1, 0, 0}};
  const Json speed_errors = {{"net", "speed-errors"}, {"gains", proportional}};
  EXPECT_EQ(refusal(speed_errors), "");
  EXPECT_EQ(refusal({{"allocation", "decoupled"}, {"pole_x", 0.1}}), "");
  EXPECT_EQ(refusal({{"pole_x", 0.1}}),
            "pole_x is 0.1; must be 0 unless form is \"positional\" and allocation \"decoupled\"");
  EXPECT_EQ(refusal({{"activation", "linear"}, {"amplitude_y", 2}}),
            "amplitude_y is 2; must be 1 with activation \"linear\"");
  EXPECT_EQ(refusal({{"speed_gain_theta", 2}}),
            "speed_gain_theta is 2; must be 0 unless net is \"speed-errors\"");
  EXPECT_EQ(refusal({{"net", "speed-errors"}, {"gains", proportional}, {"frame", "world"}}),
            "frame is \"world\"; must be \"robot\" with net \"speed-errors\"");
  EXPECT_EQ(refusal({{"net", "speed-errors"}, {"gains", {{1, 0, 0}, {1, 1, 1}, {1, 0, 3}}}}),
            "gains is 3; must be 0 for ki and kd of x and theta with net \"speed-errors\"");
  EXPECT_EQ(refusal({{"memory", 2000}, {"net", "whole"}}),
            "free taps and a memory beyond 1024 run eq. 34 alone; net, amplitudes, poles and "
            "integrals must be at their defaults, and lateral must not be \"scheduled\"");
}

// A run takes the sample time of its own scenario alone, to within what a log's stamps can tell.
TEST(SampleTime, DecidesWhichRunsThereAre) {
  ControllerDesign design;
  EXPECT_FALSE(design.sample_time.has_value());
  for (const double dt : {1e-6, 0.05, 1e3}) EXPECT_TRUE(explain_sample_time(design, dt));
  design.sample_time = 0.2;
  EXPECT_TRUE(explain_sample_time(design, 0.2 * (1 + 9e-10)));
  EXPECT_FALSE(explain_sample_time(design, 0.2 * (1 + 2e-9)));
  EXPECT_EQ(explain_sample_time(design, 0.05).message,
            "sample_time of the controller is 0.2 s; must be the scenario's dt, 0.05 s "
            "(nfopidn.fractional.retune converts gains)");
  Scenario scenario = Scenario::published();
  EXPECT_FALSE(simulate(scenario, design).diverged);
  scenario.trajectory = make([] {
    TrajectorySettings settings;
    settings.dt = 0.05;
    return settings;
  }());
  EXPECT_EQ(simulate(scenario, design).status, Status::inconsistent);
  EXPECT_EQ(*tuned_nominal().sample_time, 0.2);
}

TEST(SampleTime, OfADocumentIsNotThatOfWhatItIsReadInto) {
  ControllerDesign design = tuned_nominal();
  ASSERT_TRUE(read_controller({{"format", controller_format}, {"version", 1}}, design));
  EXPECT_FALSE(design.sample_time.has_value());
  design.sample_time = 0.1;
  ControllerDesign copy;
  ASSERT_TRUE(read_controller(write_controller(design), copy));
  EXPECT_EQ(*copy.sample_time, 0.1);
}

TEST(Documents, ALawThatIsNoneIsRefused) {
  rivals::RivalDesign design;
  const Json document = {{"format", rival_format}, {"version", 1}, {"law", "magic"}};
  const std::string message = read_rival(document, design).message;
  EXPECT_EQ(message.find("law is \"magic\"; must be one of "), 0U) << message;
  EXPECT_NE(message.find("samson"), std::string::npos) << message;
}

TEST(Tables, DecimalsAreThoseOfTheText) {
  const std::pair<const char*, int> texts[] = {
      {"12", 0}, {"1.50", 2}, {"1.5e-3", 4}, {"1.5E+3", -2}, {"0.0e-999", 401}};
  for (const auto& [text, digits] : texts) EXPECT_EQ(csv::decimals(text), digits) << text;
}

// Whole seconds could hide a missing sample as rounding: they may not.
TEST(Tables, AMissingSampleIsNoRounding) {
  const auto load = [](const std::string& text) {
    csv::Table table;
    Trajectory trajectory;
    const Outcome outcome = csv::parse("p", text, table);
    return outcome ? trajectory_from_table("p", table, {}, trajectory).message : outcome.message;
  };
  EXPECT_EQ(load("t,x,y\n0,0,0\n1,1,0\n2,2,0\n3,3,0\n4,4,0\n5,5,0\n"), "");
  EXPECT_NE(load("t,x,y\n0,0,0\n1,1,0\n2,2,0\n4,3,0\n5,4,0\n6,5,0\n").find("equal steps"),
            std::string::npos);
}

TEST(Tables, ColumnsMeanWhatTheirNamesSay) {
  const auto expect = [](const char* name, const char* quantity, double factor) {
    const csv::Meaning meaning = csv::meaning_of(name);
    EXPECT_EQ(meaning.quantity, quantity) << name;
    EXPECT_EQ(meaning.factor, factor) << name;
  };
  for (const char* name : {"t", "T", "time", "Timestamp", "stamp", "sec", "t_s", "time [s]"}) {
    expect(name, "t", 1);
  }
  expect("t (ms)", "t", 1e-3);
  expect("timestamp_ns", "t", 1e-9);
  expect("X_m", "x", 1);
  expect("y [cm]", "y", 1e-2);
  expect("tx", "x", 1);
  expect("Yaw", "theta", 1);
  expect("theta_deg", "theta", M_PI / 180);
  // What only looks like one of them keeps its own name.
  for (const char* name : {"s", "s_m", "x_ref", "tau", "t_ref", "theta_ref", "seconds_left",
                           "timeout", "x_ft", "heading", "psi_rad", "vx_mps"}) {
    expect(name, name, 1);
  }
}

TEST(Tables, KeepTheirResultWhenRefused) {
  Trajectory trajectory;
  csv::Table table;
  ASSERT_TRUE(csv::parse("p", "t,x,y\n0,0,0\n0.1,1,0\n0.2,2,1\n", table));
  ASSERT_TRUE(trajectory_from_table("p", table, {}, trajectory));
  EXPECT_EQ(trajectory.size(), 3);
  EXPECT_NEAR(trajectory.dt(), 0.1, 1e-15);
  table.rows[1] = "0.15,1,0";
  const Outcome outcome = trajectory_from_table("p", table, {}, trajectory);
  EXPECT_EQ(outcome.message.find("p:3: column t does not rise in equal steps of 0.1 s"), 0U)
      << outcome.message;
  EXPECT_EQ(trajectory.size(), 3);
}

// The ends of a closed path may lie a little apart; each lap but the last ends where it began.
TEST(Trajectory, LapsOfSamplesComeBackAsTheyWere) {
  Eigen::ArrayXd x(5), y(5);
  x << 0, 1, 1, 0, 8e-7;
  y << 0, 0, 1, 1, -3e-7;
  TrajectorySettings settings;
  settings.dt = 0.5;
  settings.laps = 3;
  Scenario scenario = Scenario::published();
  ASSERT_EQ(make_trajectory(x, y, settings, scenario.trajectory), Status::ok);
  scenario.initial_pose.reset();
  Scenario again;
  const Outcome outcome = read_scenario(write_scenario(scenario), again);
  ASSERT_TRUE(outcome) << outcome.message;
  EXPECT_TRUE((again.trajectory.x == scenario.trajectory.x).all());
  EXPECT_TRUE((again.trajectory.y == scenario.trajectory.y).all());
  EXPECT_EQ(again.trajectory.x(12), 8e-7);
}

}  // namespace
}  // namespace nfopidn::test
