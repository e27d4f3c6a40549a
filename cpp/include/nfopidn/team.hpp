// L4. Threads that share out work, and wait for more.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "nfopidn/interruption.hpp"

namespace nfopidn {

namespace detail {

// The threads of a Team besides its caller's.
class Crew {
 public:
  // What is to be done, of the parts 0, 1, ...
  using Work = std::function<void(int part)>;

  Crew() = default;
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  ~Crew() {
    begin(nullptr, size());
    for (const auto& helper : helpers_) helper->thread.join();
  }

  // Returns how many there are then, `count` if there are threads to be had.
  int hire(int count) {
    while (size() < count && !none_left_) {
      try {
        helpers_.reserve(helpers_.size() + 1);  // nothing fails once a thread runs
        auto helper = std::make_unique<Helper>();
        helper->thread =
            std::thread([this, own = helper.get(), part = size() + 1] { help(*own, part); });
        helpers_.push_back(std::move(helper));
      } catch (const std::system_error&) {
        none_left_ = true;
      }
    }
    return std::min(size(), count);
  }

  // work(0) here, and work(1) to work(helpers) on as many of the helpers. Throws what one of them
  // has thrown, when all are done. What interrupts the caller interrupts the helpers.
  void share(const Work& work, int helpers) {
    busy_ = helpers;
    interruption_ = Interruption::current();
    begin(&work, helpers);
    attempt(work, 0);
    while (busy_.load(std::memory_order_acquire) != 0) {
      Interruption::stops_here();  // nobody else would ask
      std::this_thread::yield();
    }
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

  bool is_of_this_process() const { return process_ == ::getpid(); }

 private:
  struct Helper {
    std::atomic<std::uint64_t> round{0};  // what it is called to
    std::thread thread;
  };

  int size() const { return static_cast<int>(helpers_.size()); }

  void begin(const Work* work, int helpers) {
    const std::lock_guard<std::mutex> lock(mutex_);
    work_ = work;
    for (int i = 0; i < helpers; ++i) ++helpers_[static_cast<std::size_t>(i)]->round;
    if (asleep_ > 0) wake_.notify_all();
  }

  void help(const Helper& helper, int part) {
    for (std::uint64_t seen = 0;; ++seen) {
      wait_for_round_after(seen, helper.round);
      if (work_ == nullptr) return;
      const Interruption::Borrowed borrowed(interruption_);
      attempt(*work_, part);
      busy_.fetch_sub(1, std::memory_order_release);
    }
  }

  // Between two works of a search there are microseconds: too few to fall asleep.
  void wait_for_round_after(std::uint64_t seen, const std::atomic<std::uint64_t>& round) {
    constexpr std::chrono::microseconds moment(200);
    const auto until = std::chrono::steady_clock::now() + moment;
    while (round.load(std::memory_order_acquire) == seen &&
           std::chrono::steady_clock::now() < until) {
      std::this_thread::yield();
    }
    if (round.load(std::memory_order_acquire) != seen) return;
    std::unique_lock<std::mutex> lock(mutex_);
    ++asleep_;
    wake_.wait(lock, [&] { return round.load() != seen; });
    --asleep_;
  }

  void attempt(const Work& work, int part) {
    try {
      work(part);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      failure_ = std::current_exception();
    }
  }

  const ::pid_t process_ = ::getpid();
  std::vector<std::unique_ptr<Helper>> helpers_;
  bool none_left_ = false;
  std::atomic<int> busy_{0};              // helpers that are not done
  const Work* work_ = nullptr;            // written before a round begins, read after
  Interruption* interruption_ = nullptr;  // of the caller, likewise
  std::exception_ptr failure_;            // of one of the parts
  std::mutex mutex_;
  std::condition_variable wake_;
  int asleep_ = 0;
};

}  // namespace detail

class Team {
 public:
  // Threads at work at most, the caller's among them. The others start with the first work that is
  // shared out.
  explicit Team(int threads) : threads_(std::max(1, threads)) {}
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;
  ~Team() { leave_to_other_process(); }

  int size() const { return threads_; }

  // Calls run(first, count) for equal shares of `whole`, each on a thread of its own, and not more
  // of them than `whole` has pieces of size `piece`. Where no thread is to be had, or another
  // caller has them at work, all is the caller's.
  template <class Run>
  void in_shares(std::ptrdiff_t whole, std::ptrdiff_t piece, const Run& run) {
    if (whole <= 0) return;
    const std::ptrdiff_t pieces = (whole - 1) / std::max<std::ptrdiff_t>(1, piece) + 1;
    const int wanted = static_cast<int>(std::min<std::ptrdiff_t>(threads_, pieces));
    const Turn turn(in_use_);
    const int available = wanted > 1 && turn.is_mine ? 1 + hire(wanted - 1) : 1;
    const std::ptrdiff_t share = (whole - 1) / available + 1;
    if (share >= whole) return run(std::ptrdiff_t{0}, whole);
    const auto part = [&](int index) {
      const std::ptrdiff_t first = index * share;
      if (first < whole) run(first, std::min(share, whole - first));
    };
    crew_->share(std::ref(part), available - 1);
  }

 private:
  // Held by one caller at a time, and by none that was left behind in a process before a fork.
  struct Turn {
    explicit Turn(std::atomic<::pid_t>& holder) : holder_(holder) {
      const ::pid_t here = ::getpid();
      ::pid_t other = holder.load();
      is_mine = other != here && holder.compare_exchange_strong(other, here);
    }
    ~Turn() {
      if (is_mine) holder_ = 0;
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    bool is_mine;

   private:
    std::atomic<::pid_t>& holder_;
  };

  // Helpers to be had, of `count`.
  int hire(int count) {
    leave_to_other_process();
    if (!crew_) crew_ = std::make_unique<detail::Crew>();
    return crew_->hire(count);
  }

  // A process that was forked has the crew's memory, but not its threads.
  void leave_to_other_process() {
    if (crew_ && !crew_->is_of_this_process()) static_cast<void>(crew_.release());
  }

  int threads_;
  std::atomic<::pid_t> in_use_{0};
  std::unique_ptr<detail::Crew> crew_;
};

}  // namespace nfopidn
