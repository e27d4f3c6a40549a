// Runs of a Monte Carlo analysis. Python has checked and named the arguments, and draws the
// numbers; python/nfopidn/montecarlo is the caller.
#include "bindings.hpp"
#include "nfopidn/rivals/rivals.hpp"
#include "nfopidn/tuning/measured_runs.hpp"
#include "stepping.hpp"

namespace nfopidn::python {

namespace {

// The names must be in the order of drawn_parameters().
std::vector<std::size_t> indices_of(const std::vector<std::string>& names) {
  std::vector<std::size_t> indices;
  const std::vector<DrawnParameter>& all = drawn_parameters();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (indices.size() < names.size() && all[i].name == names[indices.size()]) indices.push_back(i);
  }
  if (indices.size() == names.size()) return indices;
  throw py::value_error("names has '" + names[indices.size()] +
                        "', which is no parameter, or not in the order of drawn_parameters()");
}

// The runs of one scenario under one controller or rival.
class PyDrawnRuns {
 public:
  PyDrawnRuns(const Scenario& scenario, const py::object& controller,
              const std::vector<std::string>& names)
      : scenarios_(scenario, indices_of(names)) {
    if (py::isinstance<PyRival>(controller)) {
      const rivals::RivalDesign design = controller.cast<const PyRival&>().design;
      runs_ = std::make_unique<MonteCarloRuns>(
          scenarios_, [design](const Scenario& one) { return evaluate(prepare(one), design); });
      driver_.emplace([design](const Scenario& one) { return simulate(one, design); });
    } else {
      const ControllerDesign design = controller.cast<const PyController&>().settings;
      check("monte_carlo", explain_sample_time(design, scenario.trajectory.dt()));
      runs_ = std::make_unique<MonteCarloRuns>(scenarios_, design);
      driver_.emplace(design);
    }
  }

  // values: (n, p), p parameters in the order of drawn_parameters().
  py::array_t<double> costs(const Numbers& values, std::uint64_t first_seed, std::uint64_t step,
                            int threads) const {
    check_shape(values);
    py::array_t<double> result(values.shape(0));
    double* const costs = result.mutable_data();
    watched([&] {
      ThreadPool pool(threads);
      runs_->costs(values.data(), values.shape(0), {first_seed, step}, costs, pool);
    });
    return result;
  }

  // As costs(); every metric: (n, metrics).
  py::array_t<double> metrics(const Numbers& values, std::uint64_t first_seed, std::uint64_t step,
                              int threads) const {
    check_shape(values);
    const py::ssize_t count = values.shape(0);
    const auto width = static_cast<py::ssize_t>(field_names<Metrics>().size());
    py::array_t<double> result({count, width});
    double* rows = result.mutable_data();
    std::vector<RunFigures> figures(static_cast<std::size_t>(count));
    watched([&] {
      ThreadPool pool(threads);
      measure_drawn(scenarios_, *driver_, values.data(), count, {first_seed, step}, figures.data(),
                    pool);
    });
    for (const RunFigures& one : figures) {
      // The samples before a divergence are no whole run; the cost counts those after it too.
      Metrics::fields([&](const auto& field) {
        const bool is_whole = std::isnan(one.diverged_at) || field.member == &Metrics::cost;
        *rows++ = is_whole ? one.metrics.*field.member : infinity;
      });
    }
    return result;
  }

  // The scenario of one run; values: (p,).
  Scenario scenario(const Numbers& values, std::uint64_t seed) const {
    Scenario own = scenarios_.base();
    scenarios_.apply(values.data(), seed, own);
    return own;
  }

 private:
  void check_shape(const Numbers& values) const {
    const auto wanted = static_cast<py::ssize_t>(scenarios_.drawn_count());
    if (values.ndim() == 2 && values.shape(1) == wanted) return;
    throw py::value_error("values must have the shape (n, " + std::to_string(wanted) + ")");
  }

  DrawnScenarios scenarios_;
  std::unique_ptr<MonteCarloRuns> runs_;
  std::optional<RunDriver> driver_;
};

}  // namespace

void bind_monte_carlo(py::module_& module) {
  using R = PyDrawnRuns;
  py::class_<R> cls(module, "DrawnRuns", py::is_final(),
                    "DrawnRuns(scenario, controller, names)\n--\n\nThe runs of a Monte Carlo "
                    "analysis, of which `names` are drawn; nfopidn.monte_carlo() uses it.");
  cls.def(py::init<const Scenario&, const py::object&, const std::vector<std::string>&>(),
          py::arg("scenario"), py::arg("controller"), py::arg("names"));
  cls.def("costs", &R::costs, py::arg("values"), py::arg("first_seed"), py::arg("step"),
          py::arg("threads"),
          "costs(self, values, first_seed, step, threads)\n--\n\n(n,): the cost of each run.");
  cls.def("metrics", &R::metrics, py::arg("values"), py::arg("first_seed"), py::arg("step"),
          py::arg("threads"),
          "metrics(self, values, first_seed, step, threads)\n--\n\n(n, 13): each run's metrics.");
  cls.def("scenario", &R::scenario, py::arg("values"), py::arg("seed"),
          "scenario(self, values, seed)\n--\n\nThe Scenario of one run.");
  module.def("drawn_parameters", [] {
    py::dict result;
    for (const DrawnParameter& one : drawn_parameters()) {
      result[one.name] = py::make_tuple(one.unit, one.range.low, one.range.high, one.text);
    }
    return result;
  });
}

}  // namespace nfopidn::python
