// L4. Threads that share out work, and wait for more.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace nfopidn {

// Helpers start with the first work that is shared out. Between one work and the next, which in a
// search is a matter of microseconds, they look out for it for a moment before they sleep.
class Team {
 public:
  // Threads at work at most, the caller's among them.
  explicit Team(int threads) : threads_(std::max(1, threads)) {}
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;
  ~Team() { leave_to_other_process(); }

  // Calls run(first, count) for shares of `whole` that are equal, and of at least `least`, each on
  // a thread of its own; where no thread is to be had, and for a caller on another thread while
  // this one is at it, all on the caller's. run() must not throw on another thread.
  template <class Run>
  void in_shares(int whole, int least, const Run& run) {
    if (whole <= 0) return;
    const int most = (whole - 1) / std::max(1, least) + 1;
    const int wanted = std::min(threads_, most);
    const std::unique_lock<std::mutex> alone(in_use_, std::try_to_lock);
    const int available = wanted > 1 && alone ? 1 + hire(wanted - 1) : 1;
    const int share = (whole - 1) / std::min(available, wanted) + 1;
    if (share >= whole) return run(0, whole);
    const auto part = [&](int index) {
      const std::int64_t first = std::int64_t{index} * share;
      const std::int64_t count = std::min<std::int64_t>(share, whole - first);
      if (count > 0) run(static_cast<int>(first), static_cast<int>(count));
    };
    crew_->work([](const void* context,
                   int index) { (*static_cast<const decltype(part)*>(context))(index); },
                &part);
  }

 private:
  using Part = void (*)(const void* context, int index);

  class Crew {
   public:
    ~Crew() {
      begin(nullptr, nullptr);
      for (std::thread& helper : helpers_) helper.join();
    }

    // Returns how many there are now.
    int hire(int count) {
      try {
        while (static_cast<int>(helpers_.size()) < count) {
          const int index = static_cast<int>(helpers_.size()) + 1;
          helpers_.emplace_back([this, index, seen = round_.load()] { help(index, seen); });
        }
      } catch (const std::system_error&) {
        // With those that there are.
      }
      return static_cast<int>(helpers_.size());
    }

    // Calls part(context, index) with 0 here, and with each helper's index there.
    void work(Part part, const void* context) {
      struct Finish {
        Crew& crew;
        ~Finish() {
          while (crew.busy_.load(std::memory_order_acquire) != 0) std::this_thread::yield();
        }
      } finish{*this};
      busy_ = static_cast<int>(helpers_.size());
      begin(part, context);
      part(context, 0);
    }

    bool is_of_this_process() const { return process_ == ::getpid(); }

   private:
    void begin(Part part, const void* context) {
      const std::lock_guard<std::mutex> lock(mutex_);
      part_ = part;
      context_ = context;
      ++round_;
      if (asleep_ > 0) wake_.notify_all();
    }

    void help(int index, std::uint64_t seen) {
      for (;; ++seen) {
        wait_for_round_after(seen);
        if (part_ == nullptr) return;
        part_(context_, index);
        busy_.fetch_sub(1, std::memory_order_release);
      }
    }

    void wait_for_round_after(std::uint64_t seen) {
      constexpr std::chrono::microseconds moment(200);
      const auto until = std::chrono::steady_clock::now() + moment;
      while (round_.load(std::memory_order_acquire) == seen) {
        if (std::chrono::steady_clock::now() < until) {
          std::this_thread::yield();
          continue;
        }
        std::unique_lock<std::mutex> lock(mutex_);
        ++asleep_;
        wake_.wait(lock, [&] { return round_ != seen; });
        --asleep_;
      }
    }

    const ::pid_t process_ = ::getpid();
    std::vector<std::thread> helpers_;
    std::atomic<std::uint64_t> round_{0};
    std::atomic<int> busy_{0};  // helpers that are not done
    // Written under the mutex before a round begins, read after.
    Part part_ = nullptr;
    const void* context_ = nullptr;
    std::mutex mutex_;
    std::condition_variable wake_;
    int asleep_ = 0;
  };

  // Helpers to be had, of `count`.
  int hire(int count) {
    leave_to_other_process();
    if (!crew_) crew_ = std::make_unique<Crew>();
    return crew_->hire(count);
  }

  // A process that was forked has the crew's memory, but not its threads.
  void leave_to_other_process() {
    if (crew_ && !crew_->is_of_this_process()) static_cast<void>(crew_.release());
  }

  int threads_;
  std::mutex in_use_;
  std::unique_ptr<Crew> crew_;
};

}  // namespace nfopidn
