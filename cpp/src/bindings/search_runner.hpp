// The searches of the core as Python asks for them: with a callback, Ctrl-C, and a checkpoint.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "function_objective.hpp"
#include "nfopidn/io/checkpoint.hpp"
#include "nfopidn/io/json_method.hpp"
#include "nfopidn/tuning/tune.hpp"

namespace nfopidn::python {

using Clock = std::chrono::steady_clock;

// The options of the method of that name.
inline MethodOptions read_options(const std::string& method, const py::dict& given) {
  MethodOptions options;
  check("options", read_method(method, to_json(given), options));
  return options;
}

// What a search is given besides its objective, from the dictionary that Python makes of its
// arguments.
struct Request {
  SearchSettings search;
  std::string checkpoint;  // a path; empty: none
  py::object callback;
  py::object engine;       // a function that EngineObjective calls, or None
  int engine_workers = 1;  // that answer at a time

  explicit Request(const py::dict& given)
      : checkpoint(given["checkpoint"].cast<std::string>()),
        callback(given["callback"]),
        engine(given["engine"]),
        engine_workers(given["engine_workers"].cast<int>()) {
    search.method =
        read_options(given["method"].cast<std::string>(), given["options"].cast<py::dict>());
    search.limits = {given["maxfev"].cast<std::int64_t>(), given["maxtime"].cast<double>(),
                     given["stopval"].cast<double>()};
    search.seed = given["seed"].cast<std::uint64_t>();
  }
};

inline Json parse_problem(const std::string& text) {
  Json problem;
  check("checkpoint", parse_json(text, problem));
  return problem;
}

// Saves a search now and then: not more often than twice a second, and not for more than a
// twentieth of the time. What cannot be written now is written later.
class Checkpoint {
 public:
  Checkpoint(std::string path, Json problem) : file_(std::move(path), std::move(problem)) {}

  bool is_wanted() const { return !file_.path().empty(); }

  // Before the search begins. What is not as it should be, though the search can go on, is warned
  // of.
  void begin(SearchSession& search) {
    check("checkpoint", check_writable(file_.path()));
    check("checkpoint", file_.lock());
    std::string note;
    check("checkpoint", file_.load(search, note));
    if (!note.empty()) warn(note);
  }

  void save_if_due(const SearchSession& search) {
    if (!is_wanted() || Clock::now() < next_) return;
    save(search, false);
  }
  // Not while an earlier process's answers are still being repeated: the file has more. Nor what no
  // search can go on from.
  void save(const SearchSession& search, bool last) {
    if (!is_wanted() || search.is_replaying() || is_spoilt(search.record())) return;
    const Clock::time_point begin = Clock::now();
    const Outcome before = std::exchange(fault, file_.save(search));
    if (!fault && before && !last) warn_of_fault();
    const Clock::time_point end = Clock::now();
    const Clock::duration least = std::chrono::milliseconds(500);
    next_ = end + std::max(least, 20 * (end - begin));
  }

  Outcome fault;                   // of the last time
  py::object raised = py::none();  // where warnings are errors; the search then ends

 private:
  bool is_spoilt(const std::vector<double>& record) {
    const auto is_nan = [](double answer) { return std::isnan(answer); };
    spoilt_ = spoilt_ || std::any_of(record.begin() + seen_, record.end(), is_nan);
    seen_ = static_cast<std::ptrdiff_t>(record.size());
    return spoilt_;
  }

  static void warn(const std::string& note) {
    const std::string text = "checkpoint: " + printable(note);
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) != 0) throw py::error_already_set();
  }

  // The search goes on: the disk may have room again before it ends.
  void warn_of_fault() {
    const py::gil_scoped_acquire acquire;
    try {
      warn(fault.message + "; the search goes on, and tries again");
    } catch (const py::error_already_set& error) {
      raised = raised_by(error);
    }
  }

  CheckpointFile file_;
  std::ptrdiff_t seen_ = 0;  // answers looked at
  bool spoilt_ = false;
  Clock::time_point next_ = Clock::now() + std::chrono::milliseconds(500);
};

// A checkpoint's costs must be the objective's: of another version of the library they are not, and
// the seed would have led elsewhere. Gradients and lanes round otherwise, which changes the costs
// of controllers that hardly track.
inline void check_resumed(Objective& objective, const std::string& path,
                          const SearchResult& found) {
  constexpr double tracking = 0.1;
  if (!objective.is_cheap() || found.x.size() == 0 || !(found.cost < tracking)) return;
  double cost = 0;
  objective.costs(found.x, &cost);
  if (std::fabs(cost - found.cost) <= 1e-6 * std::fabs(cost)) return;
  raise("checkpoint",
        {Status::inconsistent, path + ": holds costs that are not this search's (" +
                                   number_text(found.cost) + " where it is " + number_text(cost) +
                                   "); give another path, or remove it"});
}

// Runs searches without the GIL, with which it is called; the callback and Ctrl-C are looked after
// between steps.
class SearchRunner : public StageRunner {
 public:
  // By the name of a stage, what its checkpoint must agree with, but for its start and its budget.
  using Problems = std::map<std::string, Json>;

  SearchRunner(const Request& request, Problems problems)
      : request_(request), problems_(std::move(problems)) {}

  // The suffix of a stage's checkpoint.
  static std::string suffix(const std::string& stage) { return stage.empty() ? "" : "." + stage; }

  bool has_begun(const PlannedStage& stage) const override {
    return !request_.checkpoint.empty() && file_exists(request_.checkpoint + suffix(stage.name));
  }
  bool has_failed() const override { return !raised.is_none() || fault.status != Status::ok; }

  SearchResult run(const SearchStage& stage, Objective& objective) override {
    return run_on_engine(stage.planned.name, objective, stage.planned.space.box(), stage.search,
                         stage.start, stage.spent);
  }
  // As run(), with the costs from the request's engine if it has one.
  SearchResult run_on_engine(const std::string& name, Objective& objective, const Box& box,
                             const SearchSettings& settings, const Point& start,
                             std::int64_t spent) {
    if (request_.engine.is_none()) return run(name, objective, box, settings, start, spent);
    EngineObjective remote(request_.engine.cast<py::function>(), request_.engine_workers, name,
                           objective);
    SearchResult found = run(name, remote, box, settings, start, spent);
    if (!remote.raised.is_none()) raised = remote.raised;
    return found;
  }
  SearchResult run(const std::string& name, Objective& objective, const Box& box,
                   const SearchSettings& settings, const Point& start, std::int64_t spent) {
    const StandardArithmetic arithmetic;
    SearchSession search(objective, box, settings.limits, settings.seed);
    search.start = start;
    Checkpoint checkpoint(path(name), problem(name, settings, start));
    if (checkpoint.is_wanted()) {
      checkpoint.begin(search);
      search.set_witness([&] { checkpoint.save_if_due(search); });
    }
    const bool resumes = search.is_replaying();
    search.keeps_record = checkpoint.is_wanted();
    Clock::time_point next_look{};
    search.set_interruption([&] {
      if (!checkpoint.raised.is_none()) return true;
      if (Clock::now() < next_look) return false;
      next_look = Clock::now() + std::chrono::milliseconds(50);
      return look_for_signals();
    });
    search.set_callback([&](const SearchResult& so_far) {
      if (!checkpoint.raised.is_none()) return false;
      if (request_.callback.is_none() || search.is_replaying()) return true;
      return tell(so_far, spent);
    });
    {
      const py::gil_scoped_release release;
      run_method(search, settings.method);
    }
    if (resumes) check_resumed(objective, path(name), search.result);
    checkpoint.save(search, true);
    fault = checkpoint.fault;
    if (raised.is_none()) raised = checkpoint.raised;
    search.result.seconds = search.elapsed();
    return search.result;
  }

  py::dict reply(const SearchResult& found) const {
    static const char* const reasons[] = {"schedule", "evaluations", "time",
                                          "target",   "callback",    "not_a_number"};
    py::dict reply;
    reply["x"] = found.x;  // empty where the search ended before its first cost
    reply["fun"] = found.cost;
    reply["nfev"] = found.evaluations;
    reply["reason"] = interrupted_ ? "interrupted" : reasons[static_cast<int>(found.reason)];
    reply["population"] = RowPoints(found.population.transpose());
    reply["population_energies"] = found.population_costs;
    reply["history"] = history_of(found);
    reply["elapsed"] = found.seconds;
    reply["checkpoint_fault"] = fault.message;
    reply["raised"] = raised;
    return reply;
  }

  Outcome fault;                   // of the last checkpoint
  py::object raised = py::none();  // by the callback, a signal's handler or a warning

 private:
  std::string path(const std::string& name) const {
    return request_.checkpoint.empty() ? "" : request_.checkpoint + suffix(name);
  }

  Json problem(const std::string& name, const SearchSettings& settings, const Point& start) const {
    const auto found = problems_.find(name);
    if (found == problems_.end()) return {};
    Json problem = found->second;
    problem["maxfev"] = settings.limits.evaluations;
    if (start.size() > 0) problem["start"] = std::vector<double>(start.begin(), start.end());
    return problem;
  }

  bool look_for_signals() {
    const py::gil_scoped_acquire acquire;
    if (!StopIf::raises()) return false;
    interrupted_ = true;
    const py::error_already_set error;
    if (!error.matches(PyExc_KeyboardInterrupt)) raised = raised_by(error);
    return true;
  }

  bool tell(const SearchResult& so_far, std::int64_t spent) {
    const py::gil_scoped_acquire acquire;
    const HistoryRow& row = so_far.history.back();
    try {
      return request_
          .callback(so_far.x, so_far.cost, spent + so_far.evaluations, row.mean, row.step,
                    RowPoints(so_far.population.transpose()), so_far.population_costs)
          .cast<bool>();
    } catch (const py::error_already_set& error) {
      raised = raised_by(error);
      return false;
    }
  }

  static py::array_t<double> history_of(const SearchResult& found) {
    py::array_t<double> history({found.history.size(), std::size_t{7}});
    auto cell = history.mutable_unchecked<2>();
    py::ssize_t row = 0;
    for (const HistoryRow& h : found.history) {
      const double numbers[] = {static_cast<double>(h.dispersal),
                                static_cast<double>(h.reproduction),
                                static_cast<double>(h.chemotaxis),
                                static_cast<double>(h.evaluations),
                                h.best,
                                h.mean,
                                h.step};
      for (py::ssize_t column = 0; column < 7; ++column) cell(row, column) = numbers[column];
      ++row;
    }
    return history;
  }

  const Request& request_;
  Problems problems_;
  bool interrupted_ = false;
};

}  // namespace nfopidn::python
