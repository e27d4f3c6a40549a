// The command of nfopidn_sim, for `nfopidn simulate`.
#include <pybind11/stl.h>

#include <csignal>

#include "bindings.hpp"
#include "commands/nfopidn_sim/command.hpp"

namespace nfopidn::python {

namespace {

// While one exists, signals act on the process as they do on an executable: Python's handlers,
// which would wait until the work is done, are set aside and come back at the end. Ctrl-C and
// SIGTERM stay ignored where they are; SIGPIPE, which Python itself ignores, ends the process.
class ExecutableSignals {
 public:
  ExecutableSignals() {
    struct sigaction usual = {};
    usual.sa_handler = SIG_DFL;
    for (std::size_t i = 0; i < count; ++i) {
      ::sigaction(signals[i], nullptr, &before_[i]);
      const bool ignored = signals[i] != SIGPIPE && before_[i].sa_handler == SIG_IGN;
      if (!ignored) ::sigaction(signals[i], &usual, nullptr);
    }
  }
  ~ExecutableSignals() {
    for (std::size_t i = 0; i < count; ++i) ::sigaction(signals[i], &before_[i], nullptr);
  }
  ExecutableSignals(const ExecutableSignals&) = delete;
  ExecutableSignals& operator=(const ExecutableSignals&) = delete;

 private:
  static constexpr std::size_t count = 3;
  static constexpr int signals[count] = {SIGINT, SIGTERM, SIGPIPE};
  struct sigaction before_[count];
};

int run_simulate(const std::string& program, const std::vector<std::string>& words) {
  const py::gil_scoped_release release;
  const ExecutableSignals signals;
  return commands::run_simulate(program, words);
}

}  // namespace

void bind_commands(py::module_& module) {
  module.def("run_simulate", &run_simulate, Computes(), py::arg("program"), py::arg("words"));
}

}  // namespace nfopidn::python
