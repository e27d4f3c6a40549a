// L3. Ends long work early: on a signal, or because its time is up.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>

#include "nfopidn/loop/poll.hpp"

namespace nfopidn {

// While an Interruption exists, the runs that its thread starts, there or in a ThreadPool, ask it
// between two pieces whether to stop. After it has stopped one, results are invalid: its owner
// checks happened() and discards them. An Interruption within another one asks the outer one too.
class Interruption {
 public:
  using Clock = std::chrono::steady_clock;
  // True ends the work. Asked by the thread that made this alone, at most 100 times a second, and
  // not for short work; it must not throw.
  using Question = std::function<bool()>;

  explicit Interruption(Question question)
      : question_(std::move(question)), outer_(current_), next_(Clock::now() + interval) {
    current_ = this;
  }
  ~Interruption() { current_ = outer_; }
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  bool happened() const { return happened_.load(std::memory_order_relaxed); }

  // Asks, if it is time to, and tells whether to stop.
  bool ask() noexcept {
    if (happened()) return true;
    if (std::this_thread::get_id() != owner_) return false;
    const Clock::time_point now = Clock::now();
    if (now < next_) return false;
    const bool stops = (question_ && question_()) || (outer_ != nullptr && outer_->ask());
    if (stops) happened_.store(true, std::memory_order_relaxed);
    next_ = Clock::now() + interval;
    return stops;
  }

  // That of this thread's present work; null if it is not to be interrupted.
  static Interruption* current() { return current_; }
  // Whether this thread's present work is to stop.
  static bool stops_here() noexcept { return current_ != nullptr && current_->ask(); }

  // For runs with so many integration steps in a sample. Lanes take some microseconds for a step.
  static Poll poll(int substeps) {
    constexpr int steps = 2048;  // of a piece
    if (current_ == nullptr) return {};
    const auto ask = [](void* asked) { return static_cast<Interruption*>(asked)->ask(); };
    return {std::max(1, steps / std::max(1, substeps)), ask, current_};
  }

  // Makes another thread's work that of the one that this was taken from.
  class Borrowed {
   public:
    explicit Borrowed(Interruption* lender) : before_(std::exchange(current_, lender)) {}
    ~Borrowed() { current_ = before_; }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;

   private:
    Interruption* before_;
  };

 private:
  static constexpr std::chrono::milliseconds interval{10};
  static inline thread_local Interruption* current_ = nullptr;

  Question question_;
  Interruption* outer_;
  Clock::time_point next_;
  std::thread::id owner_ = std::this_thread::get_id();
  std::atomic<bool> happened_{false};
};

}  // namespace nfopidn
