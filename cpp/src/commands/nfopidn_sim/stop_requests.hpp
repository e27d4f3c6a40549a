// Ctrl-C and SIGTERM, as requests that a search heeds.
#pragma once

#include <csignal>
#include <cstddef>

namespace nfopidn::commands {

// While this is there, Ctrl-C and SIGTERM ask a search to stop; a second of either ends the
// program. One that is ignored, as a shell's background jobs ignore Ctrl-C, stays so.
class StopRequests {
 public:
  StopRequests() {
    asked_ = 0;
    struct sigaction action = {};
    action.sa_handler = [](int) {
      asked_ = 1;
      for (std::size_t i = 0; i < 2; ++i) {
        if (heeded_[i] != 0) ::signal(signals[i], SIG_DFL);
      }
    };
    for (std::size_t i = 0; i < 2; ++i) {
      ::sigaction(signals[i], nullptr, &before_[i]);
      heeded_[i] = before_[i].sa_handler == SIG_IGN ? 0 : 1;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      if (heeded_[i] != 0) ::sigaction(signals[i], &action, nullptr);
    }
  }
  ~StopRequests() {
    for (std::size_t i = 0; i < 2; ++i) ::sigaction(signals[i], &before_[i], nullptr);
  }
  StopRequests(const StopRequests&) = delete;
  StopRequests& operator=(const StopRequests&) = delete;

  static bool asked() { return asked_ != 0; }

 private:
  static constexpr int signals[] = {SIGINT, SIGTERM};
  static inline volatile std::sig_atomic_t asked_ = 0;
  static inline volatile std::sig_atomic_t heeded_[2] = {};
  struct sigaction before_[2];
};

}  // namespace nfopidn::commands
