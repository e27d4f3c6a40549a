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

#include "nfopidn/parallel/interruption.hpp"

namespace nfopidn {

namespace detail {

// The threads of a ThreadPool besides its caller's.
class WorkerThreads {
 public:
  // What is to be done, of the parts 0, 1, ...
  using Work = std::function<void(int part)>;

  WorkerThreads() = default;
  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;
  ~WorkerThreads() {
    begin(nullptr, size());
    for (const auto& helper : threads_of_pool_) helper->thread.join();
  }

  // Returns how many there are then, `count` if there are threads to be had.
  int start_threads(int count) {
    while (size() < count && !none_left_) {
      try {
        threads_of_pool_.reserve(threads_of_pool_.size() + 1);  // nothing fails once a thread runs
        auto helper = std::make_unique<Worker>();
        helper->thread =
            std::thread([this, own = helper.get(), part = size() + 1] { help(*own, part); });
        threads_of_pool_.push_back(std::move(helper));
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

  bool belongs_to_this_process() const { return process_ == ::getpid(); }

 private:
  struct Worker {
    std::atomic<std::uint64_t> round{0};  // what it is called to
    std::thread thread;
  };

  int size() const { return static_cast<int>(threads_of_pool_.size()); }

  void begin(const Work* work, int helpers) {
    const std::lock_guard<std::mutex> lock(mutex_);
    work_ = work;
    for (int i = 0; i < helpers; ++i) ++threads_of_pool_[static_cast<std::size_t>(i)]->round;
    if (asleep_ > 0) wake_.notify_all();
  }

  void help(const Worker& helper, int part) {
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
  std::vector<std::unique_ptr<Worker>> threads_of_pool_;
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

class ThreadPool {
 public:
  // Threads at work at most, the caller's among them. The others start with the first work that is
  // shared out.
  explicit ThreadPool(int threads) : threads_(std::max(1, threads)) {}
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool() { abandon_after_fork(); }

  int size() const { return threads_; }

  // Calls run(first, count) for equal shares of `whole`, each on a thread of its own, and not more
  // of them than `whole` has pieces of size `piece`. Where no thread is to be had, or another
  // caller has them at work, all is the caller's.
  template <class Run>
  void for_each_share(std::ptrdiff_t whole, std::ptrdiff_t piece, const Run& run) {
    if (whole <= 0) return;
    const std::ptrdiff_t pieces = (whole - 1) / std::max<std::ptrdiff_t>(1, piece) + 1;
    const int wanted = static_cast<int>(std::min<std::ptrdiff_t>(threads_, pieces));
    const Turn turn(in_use_);
    const int available = wanted > 1 && turn.is_mine ? 1 + start_threads(wanted - 1) : 1;
    const std::ptrdiff_t share = (whole - 1) / available + 1;
    if (share >= whole) return run(std::ptrdiff_t{0}, whole);
    const auto part = [&](int index) {
      const std::ptrdiff_t first = index * share;
      if (first < whole) run(first, std::min(share, whole - first));
    };
    workers_->share(std::ref(part), available - 1);
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
  int start_threads(int count) {
    abandon_after_fork();
    if (!workers_) workers_ = std::make_unique<detail::WorkerThreads>();
    return workers_->start_threads(count);
  }

  // A process that was forked has the crew's memory, but not its threads.
  void abandon_after_fork() {
    if (workers_ && !workers_->belongs_to_this_process()) static_cast<void>(workers_.release());
  }

  int threads_;
  std::atomic<::pid_t> in_use_{0};
  std::unique_ptr<detail::WorkerThreads> workers_;
};

}  // namespace nfopidn
