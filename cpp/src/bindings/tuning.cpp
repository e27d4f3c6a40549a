// The searches, over a controller's parameters or any Python function. Python has checked and named
// the arguments; python/nfopidn/_search.py and _tuning.py are the callers.
#include "nfopidn/rivals/tuning.hpp"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "nfopidn/io/checkpoint.hpp"
#include "nfopidn/io/json_method.hpp"
#include "nfopidn/tuning/tune.hpp"

namespace nfopidn::python {

namespace {

using RowPoints = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Clock = std::chrono::steady_clock;

// What Python code has raised, with the lines that it came from.
py::object raised_by(const py::error_already_set& error) {
  py::object value = error.value();
  if (error.trace()) PyException_SetTraceback(value.ptr(), error.trace().ptr());
  return value;
}

// A Python function of an (n, p) array that returns n costs. What it raises ends the search and is
// kept, so that the caller can be given the best so far with it.
class FunctionObjective : public Objective {
 public:
  FunctionObjective(py::function function, Eigen::Index most)
      : function_(std::move(function)), most_(most) {}

  Eigen::Index most_at_once() const override { return most_; }

  void costs(const Points& points, double* costs) override {
    const py::gil_scoped_acquire acquire;
    std::fill(costs, costs + points.cols(), std::numeric_limits<double>::quiet_NaN());
    if (!raised.is_none()) return;
    try {
      const RowPoints rows = points.transpose();
      const auto reply =
          function_(rows).cast<py::array_t<double, py::array::c_style | py::array::forcecast>>();
      if (reply.ndim() != 1 || reply.size() != points.cols()) {
        throw py::value_error("func must return " + std::to_string(points.cols()) +
                              " costs for as many points, shape (" + std::to_string(points.cols()) +
                              ",)");
      }
      std::copy(reply.data(), reply.data() + reply.size(), costs);
    } catch (const py::error_already_set& error) {
      raised = raised_by(error);
      keep_answers(costs, points.cols());
    } catch (const py::cast_error&) {
      raised = py::module_::import("builtins").attr("ValueError")("func must return numbers");
    } catch (const py::builtin_exception& error) {
      raised = py::module_::import("builtins").attr("ValueError")(error.what());
    }
  }

  py::object raised = py::none();

 private:
  // Of the points before the one that raised.
  void keep_answers(double* costs, Eigen::Index count) const {
    const py::object answered = py::getattr(raised, "_nfopidn_answered", py::none());
    if (!py::isinstance<py::list>(answered)) return;
    for (const auto& answer : answered.cast<py::list>()) {
      if (count-- <= 0 || !py::isinstance<py::float_>(answer)) return;
      *costs++ = answer.cast<double>();
    }
  }

  py::function function_;
  Eigen::Index most_;
};

const char* const reasons[] = {"schedule", "evaluations", "time",
                               "target",   "callback",    "not_a_number"};

py::dict to_dict(const SearchSession& search, const std::string& reason) {
  const SearchResult& r = search.result;
  py::array_t<double> history({r.history.size(), std::size_t{7}});
  auto cell = history.mutable_unchecked<2>();
  py::ssize_t row = 0;
  for (const HistoryRow& h : r.history) {
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
  py::dict result;
  result["x"] = r.x;  // empty where the search ended before its first cost
  result["fun"] = r.cost;
  result["nfev"] = r.evaluations;
  result["reason"] = reason;
  result["population"] = RowPoints(r.population.transpose());
  result["population_energies"] = r.population_costs;
  result["history"] = history;
  result["elapsed"] = search.elapsed();
  return result;
}

// What a search is given, from the dictionary that Python makes of its arguments.
struct Request {
  std::string method, checkpoint;
  py::dict options;
  Eigen::VectorXd low, high, start;
  SearchLimits limits;
  std::uint64_t seed;
  py::object callback;
  Json problem;

  explicit Request(const py::dict& given)
      : method(given["method"].cast<std::string>()),
        checkpoint(given["checkpoint"].cast<std::string>()),
        options(given["options"].cast<py::dict>()),
        low(given["low"].cast<Eigen::VectorXd>()),
        high(given["high"].cast<Eigen::VectorXd>()),
        limits{given["maxfev"].cast<std::int64_t>(), given["maxtime"].cast<double>(),
               given["stopval"].cast<double>()},
        seed(given["seed"].cast<std::uint64_t>()),
        callback(given["callback"]) {
    if (!given["start"].is_none()) start = given["start"].cast<Eigen::VectorXd>();
    check("checkpoint", parse_json(given["problem"].cast<std::string>(), problem));
  }
};

// The options of the method of that name.
MethodOptions read_options(const std::string& method, const py::dict& given) {
  MethodOptions options;
  check("options", read_method(method, to_json(given), options));
  return options;
}

// Saves a search now and then: not more often than twice a second, and not for more than a
// twentieth of the time. What cannot be written now is written later.
class Checkpoint {
 public:
  explicit Checkpoint(const Request& request) : file_(request.checkpoint, request.problem) {}

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
void check_resumed(Objective& objective, const Request& request, const SearchResult& found) {
  constexpr double tracking = 0.1;
  if (!objective.is_cheap() || found.x.size() == 0 || !(found.cost < tracking)) return;
  double cost = 0;
  objective.costs(found.x, &cost);
  if (std::fabs(cost - found.cost) <= 1e-6 * std::fabs(cost)) return;
  raise("checkpoint",
        {Status::inconsistent, request.checkpoint + ": holds costs that are not this search's (" +
                                   number_text(found.cost) + " where it is " + number_text(cost) +
                                   "); give another path, or remove it"});
}

// Runs the search without the GIL; the callback and Ctrl-C are looked after between steps.
py::dict run_search(Objective& objective, const Request& request, const Eigen::VectorXd& power) {
  const StandardArithmetic arithmetic;
  SearchSession search(objective, {request.low, request.high, power}, request.limits, request.seed);
  search.start = request.start;
  Checkpoint checkpoint(request);
  if (checkpoint.is_wanted()) {
    checkpoint.begin(search);
    search.set_witness([&] { checkpoint.save_if_due(search); });
  }
  const bool resumes = search.is_replaying();
  search.keeps_record = checkpoint.is_wanted();
  bool interrupted = false;
  py::object raised = py::none();  // by the callback, or by a signal's handler
  Clock::time_point next_look{};
  search.set_interruption([&] {
    if (!checkpoint.raised.is_none()) return true;
    if (Clock::now() < next_look) return false;
    next_look = Clock::now() + std::chrono::milliseconds(50);
    const py::gil_scoped_acquire acquire;
    if (!StopIf::raises()) return false;
    interrupted = true;
    const py::error_already_set error;
    if (!error.matches(PyExc_KeyboardInterrupt)) raised = raised_by(error);
    return true;
  });
  search.set_callback([&](const SearchResult& so_far) {
    if (!checkpoint.raised.is_none()) return false;
    if (request.callback.is_none() || search.is_replaying()) return true;
    const py::gil_scoped_acquire acquire;
    const HistoryRow& row = so_far.history.back();
    try {
      return request
          .callback(so_far.x, so_far.cost, so_far.evaluations, row.mean, row.step,
                    RowPoints(so_far.population.transpose()), so_far.population_costs)
          .cast<bool>();
    } catch (const py::error_already_set& error) {
      raised = raised_by(error);
      return false;
    }
  });
  {
    const MethodOptions options = read_options(request.method, request.options);
    const py::gil_scoped_release release;
    run_method(search, options);
  }
  if (resumes) check_resumed(objective, request, search.result);
  checkpoint.save(search, true);
  py::dict result = to_dict(
      search, interrupted ? "interrupted" : reasons[static_cast<int>(search.result.reason)]);
  result["checkpoint_fault"] = checkpoint.fault.message;
  result["raised"] = raised.is_none() ? checkpoint.raised : raised;
  return result;
}

py::dict search_function(const py::function& function, const py::dict& given) {
  const Request request(given);
  FunctionObjective objective(function, given["most_at_once"].cast<Eigen::Index>());
  py::dict result = run_search(objective, request, Eigen::VectorXd::Ones(request.low.size()));
  if (!objective.raised.is_none()) result["raised"] = objective.raised;
  return result;
}

Structure structure_of(const PyController& controller, const std::string& parameters) {
  Structure structure = {controller.settings, ParameterSet::shared_orders};
  Outcome outcome;
  json::read(parameters, json::Context{"parameters", {}, "", &outcome}, structure.parameters);
  check("structure", outcome);
  check("structure", explain_memory_to_tune(structure.settings.memory));
  return structure;
}

py::dict search_controller(const std::vector<const Scenario*>& scenarios,
                           const PyController& controller, const std::string& parameters,
                           const std::vector<int>& source, const std::vector<double>& fixed,
                           double worst_share, const std::vector<double>& caps, int threads,
                           const py::dict& given) {
  const Request request(given);
  const Structure structure = structure_of(controller, parameters);
  const FreeParameters free = {source, fixed};
  TuneObjective objective(scenarios, structure, free, static_cast<int>(request.low.size()),
                          {worst_share, caps}, threads);
  return run_search(objective, request, tuning_powers(structure, free, request.low));
}

py::dict search_rival(const std::vector<const Scenario*>& scenarios,
                      const rivals::RivalDesign& rival, const std::vector<int>& source,
                      const std::vector<double>& fixed, double worst_share,
                      const std::vector<double>& caps, int threads, const py::dict& given) {
  const Request request(given);
  rivals::RivalObjective objective(scenarios, rival, {source, fixed}, {worst_share, caps}, threads);
  return run_search(objective, request, tuning_powers(request.low));
}

// A controller's cost as a function of its free parameters, for other optimisers.
class PyObjective {
 public:
  PyObjective(std::vector<Scenario> scenarios, const PyController& controller,
              const std::string& parameters, const std::vector<int>& source,
              const std::vector<double>& fixed, int dimension, double worst_share,
              const std::vector<double>& caps, int threads)
      : scenarios_(std::move(scenarios)),
        dimension_(dimension),
        objective_(pointers(), structure_of(controller, parameters), {source, fixed}, dimension,
                   {worst_share, caps}, threads) {}

  py::array_t<double> costs(const RowPoints& points) {
    if (points.cols() != dimension_) {
      throw py::value_error("points have " + std::to_string(points.cols()) +
                            " columns; must have " + std::to_string(dimension_));
    }
    const Points columns = points.transpose();
    py::array_t<double> result(points.rows());
    double* const costs = result.mutable_data();
    watched([&] { objective_.costs(columns, costs); });
    return result;
  }
  std::pair<double, Eigen::VectorXd> gradient(const Eigen::VectorXd& x) {
    if (x.size() != dimension_) {
      throw py::value_error("x has " + std::to_string(x.size()) + " numbers; must have " +
                            std::to_string(dimension_));
    }
    Eigen::VectorXd slopes(x.size());
    double cost = 0;
    watched([&] { cost = objective_.gradient(x, slopes.data()); });
    return {cost, std::move(slopes)};
  }

 private:
  std::vector<const Scenario*> pointers() const {
    std::vector<const Scenario*> result;
    for (const Scenario& scenario : scenarios_) result.push_back(&scenario);
    return result;
  }

  std::vector<Scenario> scenarios_;
  int dimension_;
  TuneObjective objective_;
};

py::tuple structure_by_name(const std::string& name) {
  StructureName choice{};
  Outcome outcome;
  json::read(name, json::Context{"structure", {}, "", &outcome}, choice);
  check("tune", outcome);
  const Structure structure = named_structure(choice);
  const Json published = write_settings(ControllerSettings<double>{});
  py::dict changes;
  const Json settings = write_settings<ControllerSettings<double>>(structure.settings);
  for (const auto& item : settings.items()) {
    if (item.value() != published[item.key()])
      changes[py::str(item.key())] = from_json(item.value());
  }
  return py::make_tuple(changes, json::write(structure.parameters).get<std::string>());
}

std::vector<std::tuple<std::string, double, double>> bounds_of(const PyController& controller,
                                                               const std::string& parameters,
                                                               const Scenario* scenario) {
  std::vector<std::tuple<std::string, double, double>> result;
  Structure structure = structure_of(controller, parameters);
  if (scenario != nullptr) structure.scale = tracking_scale(*scenario);
  for (const ParameterBounds& b : default_bounds(structure)) {
    result.emplace_back(b.name, b.low, b.high);
  }
  return result;
}

// The controller of a search's x; what is not searched for is fixed.
PyController design(const PyController& controller, const std::string& parameters,
                    const std::vector<int>& source, const std::vector<double>& fixed,
                    const std::vector<double>& x) {
  const FreeParameters free = {source, fixed};
  const int size = source.empty() ? 0 : *std::max_element(source.begin(), source.end()) + 1;
  if (static_cast<int>(x.size()) != size) {
    throw py::value_error("x has " + std::to_string(x.size()) + " numbers; must have " +
                          std::to_string(size));
  }
  ControllerDesign design = design_of(structure_of(controller, parameters), free.full(x.data()));
  design.robot = controller.settings.robot;
  return PyController(design);
}

// The parameters that a controller has in a structure.
std::vector<double> parameters(const PyController& controller, const std::string& parameters,
                               const PyController& design) {
  return parameters_of(structure_of(controller, parameters).parameters, design.settings);
}

py::dict defaults_of(const std::string& method) {
  return from_json(write_options(read_options(method, {}))).cast<py::dict>();
}

// Refuses options that a search would refuse.
void check_options_of(const std::string& method, const py::dict& options) {
  read_options(method, options);
}

// The default budgets of all methods by name, the default method first.
py::dict methods() {
  py::dict budgets;
  for_each_method([&](auto* method) {
    using Method = MethodOf<decltype(method)>;
    budgets[Method::name] = Method::default_budget;
  });
  return budgets;
}

}  // namespace

void bind_tuning(py::module_& module) {
  module.attr("START_SHARE") = start_share;
  module.attr("METHODS") = methods();
  module.attr("UNLIMITED") = unlimited_budget;
  py::list laterals;
  for (const Lateral lateral : free_tap_laterals) {
    laterals.append(json::write(lateral).get<std::string>());
  }
  module.attr("FREE_TAP_LATERALS") = py::tuple(laterals);
  py::class_<PyObjective>(
      module, "CostFunction", py::is_final(),
      "CostFunction(scenarios, controller, parameters, source, fixed, "
      "dimension, worst_share, caps, threads)\n--\n\nWhat nfopidn.Objective is made of.")
      .def(py::init<std::vector<Scenario>, const PyController&, const std::string&,
                    const std::vector<int>&, const std::vector<double>&, int, double,
                    const std::vector<double>&, int>(),
           Computes(), py::arg("scenarios"), py::arg("controller"), py::arg("parameters"),
           py::arg("source"), py::arg("fixed"), py::arg("dimension"), py::arg("worst_share"),
           py::arg("caps"), py::arg("threads"))
      .def("costs", &PyObjective::costs, Computes(), "costs(self, points)\n--\n\n(n, p) to (n,).",
           py::arg("points"))
      .def("gradient", &PyObjective::gradient,
           "gradient(self, x)\n--\n\nThe cost at x, and its partial derivatives.", py::arg("x"));
  module.def("search_function", &search_function, Computes(), py::arg("function"),
             py::arg("request"));
  module.def("search_controller", &search_controller, Computes(), py::arg("scenarios"),
             py::arg("controller"), py::arg("parameters"), py::arg("source"), py::arg("fixed"),
             py::arg("worst_share"), py::arg("caps"), py::arg("threads"), py::arg("request"));
  module.def("search_rival", &search_rival, Computes(), py::arg("scenarios"), py::arg("rival"),
             py::arg("source"), py::arg("fixed"), py::arg("worst_share"), py::arg("caps"),
             py::arg("threads"), py::arg("request"));
  module.def("family_cap", &family_cap, Computes(), py::arg("scenario"));
  module.def(
      "checkpoint_problem",
      [](const std::string& path) -> py::object {
        const Json problem = checkpoint_problem(path);
        if (problem.is_null()) return py::none();
        return py::str(problem.dump());
      },
      py::arg("path"));
  module.def("structure", &structure_by_name, Computes(), py::arg("name"));
  module.def("parameter_bounds", &bounds_of, Computes(), py::arg("controller"),
             py::arg("parameters"), py::arg("scenario") = py::none());
  module.def("design", &design, Computes(), py::arg("controller"), py::arg("parameters"),
             py::arg("source"), py::arg("fixed"), py::arg("x"));
  module.def("parameters", &parameters, Computes(), py::arg("controller"), py::arg("parameters"),
             py::arg("design"));
  module.def("default_options", &defaults_of, Computes(), py::arg("method"));
  module.def("check_options", &check_options_of, Computes(), py::arg("method"), py::arg("options"));
}

}  // namespace nfopidn::python
