// Shares of work on several threads.
#include <sys/wait.h>

#include <limits>
#include <stdexcept>

#include "nfopidn/parallel/thread_pool.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

std::vector<int> times_run(ThreadPool& team, int whole, int piece,
                           std::vector<int>* shares = nullptr) {
  std::vector<std::atomic<int>> times(static_cast<std::size_t>(whole));
  std::mutex mutex;
  team.for_each_share(whole, piece, [&](std::ptrdiff_t first, std::ptrdiff_t count) {
    for (auto i = first; i < first + count; ++i) ++times[static_cast<std::size_t>(i)];
    const std::lock_guard<std::mutex> lock(mutex);
    if (shares != nullptr) shares->push_back(static_cast<int>(count));
  });
  return {times.begin(), times.end()};
}

// Each of the whole once, however many threads are asked for, again and again.
TEST(ThreadPool, CoversTheWholeOnce) {
  for (const int threads : {-1, 0, 1, 2, 3, 63, std::numeric_limits<int>::max()}) {
    ThreadPool team(threads);
    for (const int whole : {0, 1, 2, 7, 64, 5, 64}) {
      const std::vector<int> once(static_cast<std::size_t>(whole), 1);
      EXPECT_EQ(times_run(team, whole, 1), once) << whole << ' ' << threads;
      EXPECT_EQ(times_run(team, whole, 0), once) << whole << ' ' << threads;
      EXPECT_EQ(times_run(team, whole, 8), once) << whole << ' ' << threads;
    }
  }
  ThreadPool team(2);
  for (int round = 0; round < 2000; ++round) {
    EXPECT_EQ(times_run(team, 2, 1), std::vector<int>({1, 1}));
  }
}

TEST(ThreadPool, SharesAreEqualAndNoMoreThanPieces) {
  ThreadPool team(4);
  const auto shares = [&](int whole, int piece) {
    std::vector<int> result;
    times_run(team, whole, piece, &result);
    std::sort(result.begin(), result.end());
    return result;
  };
  EXPECT_EQ(shares(8, 1), std::vector<int>({2, 2, 2, 2}));
  EXPECT_EQ(shares(7, 1), std::vector<int>({1, 2, 2, 2}));
  EXPECT_EQ(shares(8, 8), std::vector<int>({8}));
  EXPECT_EQ(shares(9, 8), std::vector<int>({4, 5}));
  EXPECT_EQ(shares(16, 8), std::vector<int>({8, 8}));
  EXPECT_EQ(shares(100, 8), std::vector<int>({25, 25, 25, 25}));
}

TEST(ThreadPool, UsesThreadsAndKeepsThem) {
  ThreadPool team(3);
  const auto threads = [&] {
    std::mutex mutex;
    std::vector<std::thread::id> ids;
    team.for_each_share(3, 1, [&](auto, auto) {
      const std::lock_guard<std::mutex> lock(mutex);
      ids.push_back(std::this_thread::get_id());
    });
    std::sort(ids.begin(), ids.end());
    return ids;
  };
  const std::vector<std::thread::id> first = threads();
  ASSERT_EQ(first.size(), 3U);
  EXPECT_NE(first[0], first[1]);
  EXPECT_NE(first[1], first[2]);
  EXPECT_EQ(threads(), first);
}

// While others are at it, a caller does the work alone.
TEST(ThreadPool, ServesSeveralCallers) {
  ThreadPool team(2);
  std::vector<std::thread> callers;
  std::atomic<std::ptrdiff_t> sum{0};
  callers.reserve(4);
  for (int caller = 0; caller < 4; ++caller) {
    callers.emplace_back([&] {
      for (int round = 0; round < 200; ++round) {
        team.for_each_share(10, 1, [&](auto, auto count) { sum += count; });
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(sum, 4 * 200 * 10);
  // One that is called from a share is a caller of its own.
  sum = 0;
  team.for_each_share(2, 1, [&](auto, auto) {
    team.for_each_share(3, 1, [&](auto, auto count) { sum += count; });
  });
  EXPECT_EQ(sum, 6);
}

// What a share throws, its caller catches, once all shares are done.
TEST(ThreadPool, HandsOnWhatAShareThrows) {
  ThreadPool team(3);
  for (const int failing : {0, 1, 2}) {
    std::atomic<int> done{0};
    const auto fail = [&](std::ptrdiff_t first, auto) {
      if (first == failing) throw std::runtime_error("mine");
      ++done;
    };
    EXPECT_THROW(team.for_each_share(3, 1, fail), std::runtime_error);
    EXPECT_EQ(done, 2);
    EXPECT_EQ(times_run(team, 3, 1), std::vector<int>({1, 1, 1}));
  }
}

int shares_in_child(ThreadPool& team) {
  const pid_t child = fork();
  if (child == 0) {
    std::vector<int> shares;
    times_run(team, 2, 1, &shares);
    _exit(static_cast<int>(shares.size()));
  }
  int status = -1;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  return WEXITSTATUS(status);
}

// With threads of its own, even if the fork came while the parent's were at work.
TEST(ThreadPool, WorksInAForkedProcess) {
  ThreadPool team(2);
  times_run(team, 2, 1);
  EXPECT_EQ(shares_in_child(team), 2);
  int shares = 0;
  team.for_each_share(2, 1, [&](std::ptrdiff_t first, auto) {
    if (first == 0) shares = shares_in_child(team);
  });
  EXPECT_EQ(shares, 2);
  EXPECT_EQ(times_run(team, 2, 1), std::vector<int>({1, 1}));
}

}  // namespace
}  // namespace nfopidn::test
