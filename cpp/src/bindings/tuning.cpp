// The searches, over a controller's parameters or any Python function. Python has checked and named
// the arguments; python/nfopidn/search and python/nfopidn/tuning are the callers.
#include "nfopidn/rivals/tuning.hpp"

#include "function_objective.hpp"
#include "search_runner.hpp"
#include "stepping.hpp"

namespace nfopidn::python {

namespace {

// What a search in one stage is given besides.
struct BoxRequest {
  Point low, high, start;
  Json problem;

  explicit BoxRequest(const py::dict& given)
      : low(given["low"].cast<Point>()),
        high(given["high"].cast<Point>()),
        problem(parse_problem(given["problem"].cast<std::string>())) {
    if (!given["start"].is_none()) start = given["start"].cast<Point>();
  }

  SearchRunner::Problems problems() const { return {{"", problem}}; }
};

py::dict search_function(const py::function& function, const py::dict& given) {
  const Request request(given);
  const BoxRequest box(given);
  FunctionObjective objective(function, given["most_at_once"].cast<Eigen::Index>());
  SearchRunner runner(request, box.problems());
  const Point power = Point::Ones(box.low.size());
  const SearchResult found =
      runner.run("", objective, {box.low, box.high, power}, request.search, box.start, 0);
  if (!objective.raised.is_none()) runner.raised = objective.raised;
  return runner.reply(found);
}

Structure structure_of(const PyController& controller, const std::string& parameters) {
  Structure structure = {controller.settings, ParameterSet::shared_orders};
  Outcome outcome;
  json::read(parameters, json::Context{"parameters", {}, "", &outcome}, structure.parameters);
  check("structure", outcome);
  check("structure", explain_memory_to_tune(structure.settings.memory));
  return structure;
}

// A structure's parameters, with the robot that its controllers are made for.
struct PySpace : ParameterSpace {
  std::optional<Robot<double>> robot;

  PySpace(const PyController& controller, const std::string& set, const std::vector<int>& source,
          const std::vector<double>& fixed, Point lowest, Point highest)
      : ParameterSpace{structure_of(controller, set),
                       {source, fixed},
                       std::move(lowest),
                       std::move(highest)},
        robot(controller.settings.robot) {}

  PyController controller(const Point& x) const {
    if (x.size() != dimension()) {
      throw py::value_error("x has " + std::to_string(x.size()) + " numbers; must have " +
                            std::to_string(dimension()));
    }
    ControllerDesign made = design(x);
    made.robot = robot;
    return PyController(made);
  }
  Point parameters_of(const PyController& given) const { return free_parameters(given.settings); }
};

using PyStage = std::tuple<std::string, const PySpace*, std::string>;  // name, space, problem

// `gains` and `alternatives` as in TuningPlan; `start` may be empty.
py::dict run_plan(const std::vector<const Scenario*>& scenarios,
                  const std::optional<PyStage>& gains, const std::vector<PyStage>& alternatives,
                  const Point& start, double worst_share, const std::vector<double>& caps,
                  int threads, const py::dict& given) {
  const Request request(given);
  SearchRunner::Problems problems;
  const auto planned = [&](const PyStage& stage) -> PlannedStage {
    const auto& [name, space, problem] = stage;
    problems[name] = parse_problem(problem);
    return {name, *space};
  };
  TuningPlan plan;
  plan.scenarios = scenarios;
  plan.family = {worst_share, caps};
  plan.search = request.search;
  plan.threads = threads;
  plan.start = start;
  if (gains) plan.gains = planned(*gains);
  for (const PyStage& stage : alternatives) plan.alternatives.push_back(planned(stage));
  SearchRunner runner(request, problems);
  const TuningResult found = run_tuning(plan, runner);
  py::dict reply = runner.reply(found);
  reply["alternative"] = found.alternative;
  return reply;
}

// Points of the unit box, (n, p), as points of the box that tunings search; `space` gives the
// powers of a controller's parameters, those of a rival's have none of their own.
RowPoints from_unit(const PySpace* space, const Point& low, const Point& high,
                    const RowPoints& unit) {
  const Box box = space != nullptr ? space->box() : Box{low, high, tuning_powers(low)};
  if (unit.cols() != box.dimension()) throw py::value_error("unit has another number of columns");
  return box.to_user(unit.transpose()).transpose();
}

// The inverse, of one point.
Point to_unit(const PySpace* space, const Point& low, const Point& high, const Point& x) {
  const Box box = space != nullptr ? space->box() : Box{low, high, tuning_powers(low)};
  return box.to_unit(x);
}

// The stages of a search for a controller, (name, controller, parameters) each: for gains, or None,
// and the alternatives.
py::tuple plan_stages(const PyController& controller, const std::string& parameters,
                      bool either_lateral, bool has_start) {
  Structure structure = structure_of(controller, parameters);
  structure.either_lateral = either_lateral;
  const StructureStages stages = stages_of(structure, has_start);
  const auto described = [&](const NamedStructure& stage) {
    ControllerDesign design(stage.second.settings);
    design.robot = controller.settings.robot;
    return py::make_tuple(stage.first, PyController(design),
                          json::write(stage.second.parameters).get<std::string>());
  };
  py::list alternatives;
  for (const NamedStructure& stage : stages.alternatives) alternatives.append(described(stage));
  return py::make_tuple(stages.gains ? py::object(described(*stages.gains)) : py::none(),
                        alternatives);
}

// The suffixes that the checkpoints of a search's stages may have.
py::tuple stage_suffixes() {
  const StructureStages stages = stages_of(named_structure(StructureName::taps), false);
  py::list suffixes;
  suffixes.append(SearchRunner::suffix(stages.gains->first));
  for (const NamedStructure& stage : stages.alternatives) {
    if (!stage.first.empty()) suffixes.append(SearchRunner::suffix(stage.first));
  }
  return py::tuple(suffixes);
}

py::dict search_rival(const std::vector<const Scenario*>& scenarios, const PyRival& rival,
                      const std::vector<int>& source, const std::vector<double>& fixed,
                      double worst_share, const std::vector<double>& caps, int threads,
                      const py::dict& given) {
  const Request request(given);
  const BoxRequest box(given);
  rivals::RivalObjective objective(scenarios, rival.design, {source, fixed},
                                   static_cast<int>(box.low.size()), {worst_share, caps}, threads);
  SearchRunner runner(request, box.problems());
  return runner.reply(runner.run_on_engine(
      "", objective, {box.low, box.high, tuning_powers(box.low)}, request.search, box.start, 0));
}

// A controller's cost as a function of its free parameters, for other optimisers.
class PyObjective {
 public:
  PyObjective(std::vector<Scenario> scenarios, const PySpace& space, double worst_share,
              const std::vector<double>& caps, int threads)
      : scenarios_(std::move(scenarios)),
        dimension_(space.dimension()),
        objective_(std::make_unique<TuneObjective>(pointers(), space, FamilyCost{worst_share, caps},
                                                   threads)) {}
  PyObjective(std::vector<Scenario> scenarios, const rivals::RivalDesign& rival,
              const std::vector<int>& source, const std::vector<double>& fixed, int dimension,
              double worst_share, const std::vector<double>& caps, int threads)
      : scenarios_(std::move(scenarios)),
        dimension_(dimension),
        objective_(std::make_unique<rivals::RivalObjective>(
            pointers(), rival, FreeParameters{source, fixed}, dimension,
            FamilyCost{worst_share, caps}, threads)) {}

  py::array_t<double> costs(const RowPoints& points, const std::optional<Eigen::VectorXd>& bounds) {
    if (points.cols() != dimension_) {
      throw py::value_error("points have " + std::to_string(points.cols()) +
                            " columns; must have " + std::to_string(dimension_));
    }
    const Points columns = points.transpose();
    py::array_t<double> result(points.rows());
    double* const costs = result.mutable_data();
    if (bounds && bounds->size() != points.rows()) {
      throw py::value_error("bounds has " + std::to_string(bounds->size()) +
                            " numbers; must have one a point, " + std::to_string(points.rows()));
    }
    watched([&] {
      if (bounds) {
        objective_->bounded_costs(columns, bounds->data(), costs);
      } else {
        objective_->costs(columns, costs);
      }
    });
    return result;
  }
  std::pair<double, Eigen::VectorXd> gradient(const Eigen::VectorXd& x) {
    if (x.size() != dimension_) {
      throw py::value_error("x has " + std::to_string(x.size()) + " numbers; must have " +
                            std::to_string(dimension_));
    }
    Eigen::VectorXd slopes(x.size());
    double cost = 0;
    watched([&] { cost = objective_->gradient(x, slopes.data()); });
    return {cost, std::move(slopes)};
  }

 private:
  std::vector<const Scenario*> pointers() const {
    std::vector<const Scenario*> result;
    for (const Scenario& scenario : scenarios_) result.push_back(&scenario);
    return result;
  }

  std::vector<Scenario> scenarios_;
  Eigen::Index dimension_;
  std::unique_ptr<FamilyObjective> objective_;
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
  module.attr("METHODS") = methods();
  module.attr("UNLIMITED") = unlimited_budget;
  module.attr("STAGE_SUFFIXES") = stage_suffixes();
  py::class_<PySpace>(module, "ParameterSpace", py::is_final(),
                      "ParameterSpace(controller, parameters, source, fixed, low, high)\n--\n\n"
                      "What of a controller is searched for. Parameter i is x[source[i]], or "
                      "fixed[i] where source[i] is negative.")
      .def(py::init<const PyController&, const std::string&, const std::vector<int>&,
                    const std::vector<double>&, Point, Point>(),
           py::arg("controller"), py::arg("parameters"), py::arg("source"), py::arg("fixed"),
           py::arg("low"), py::arg("high"))
      .def("controller", &PySpace::controller, Computes(),
           "controller(self, x)\n--\n\nThe controller of the free parameters x (p,).", py::arg("x"))
      .def("parameters_of", &PySpace::parameters_of, Computes(),
           "parameters_of(self, controller)\n--\n\nThe free parameters (p,) of a controller.",
           py::arg("controller"));
  py::class_<PyObjective>(module, "CostFunction", py::is_final(),
                          "CostFunction(scenarios, space, worst_share, caps, threads)\n--\n\n"
                          "What nfopidn.Objective is made of.")
      .def(py::init<std::vector<Scenario>, const PySpace&, double, const std::vector<double>&,
                    int>(),
           Computes(), py::arg("scenarios"), py::arg("space"), py::arg("worst_share"),
           py::arg("caps"), py::arg("threads"))
      .def_static(
          "of_rival",
          [](std::vector<Scenario> scenarios, const PyRival& rival, const std::vector<int>& source,
             const std::vector<double>& fixed, int dimension, double worst_share,
             const std::vector<double>& caps, int threads) {
            return std::make_unique<PyObjective>(std::move(scenarios), rival.design, source, fixed,
                                                 dimension, worst_share, caps, threads);
          },
          Computes(),
          "of_rival(scenarios, rival, source, fixed, dimension, worst_share, caps, "
          "threads)\n--\n\nThe same of a rival's parameters, of which `dimension` are free.",
          py::arg("scenarios"), py::arg("rival"), py::arg("source"), py::arg("fixed"),
          py::arg("dimension"), py::arg("worst_share"), py::arg("caps"), py::arg("threads"))
      .def("costs", &PyObjective::costs, Computes(),
           "costs(self, points, bounds=None)\n--\n\n(n, p) to (n,). All costs over a point's "
           "bound may be any number over it.",
           py::arg("points"), py::arg("bounds") = py::none())
      .def("gradient", &PyObjective::gradient,
           "gradient(self, x)\n--\n\nThe cost at x, and its partial derivatives.", py::arg("x"));
  module.def("search_function", &search_function, Computes(), py::arg("function"),
             py::arg("request"));
  module.def("from_unit", &from_unit, Computes(), py::arg("space").none(true), py::arg("low"),
             py::arg("high"), py::arg("unit"));
  module.def("to_unit", &to_unit, Computes(), py::arg("space").none(true), py::arg("low"),
             py::arg("high"), py::arg("x"));
  module.def("plan_stages", &plan_stages, Computes(), py::arg("controller"), py::arg("parameters"),
             py::arg("either_lateral"), py::arg("has_start"));
  module.def("run_plan", &run_plan, Computes(), py::arg("scenarios"), py::arg("gains"),
             py::arg("alternatives"), py::arg("start"), py::arg("worst_share"), py::arg("caps"),
             py::arg("threads"), py::arg("request"));
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
  module.def("default_options", &defaults_of, Computes(), py::arg("method"));
  module.def("check_options", &check_options_of, Computes(), py::arg("method"), py::arg("options"));
}

}  // namespace nfopidn::python
