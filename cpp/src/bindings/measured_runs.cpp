// Figures of many runs. Python has checked and named the arguments; python/nfopidn/families and
// python/nfopidn/comparison are the callers.
#include "nfopidn/tuning/measured_runs.hpp"

#include "bindings.hpp"
#include "nfopidn/rivals/rivals.hpp"
#include "nfopidn/tuning/family_cost.hpp"
#include "search_runner.hpp"
#include "stepping.hpp"

namespace nfopidn::python {

namespace {

RunDriver driver_from(const py::handle& given) {
  if (py::isinstance<PyRival>(given)) {
    const rivals::RivalDesign design = given.cast<const PyRival&>().design;
    return RunDriver([design](const Scenario& one) { return simulate(one, design); });
  }
  return RunDriver(given.cast<const PyController&>().settings);
}

py::array_t<double> rows_of(const std::vector<RunFigures>& figures,
                            std::vector<py::ssize_t> shape) {
  shape.push_back(static_cast<py::ssize_t>(RunFigures::names().size()));
  py::array_t<double> rows(shape);
  double* out = rows.mutable_data();
  for (const RunFigures& one : figures) {
    one.for_each([&](const char* /*name*/, double value) { *out++ = value; });
  }
  return rows;
}

// Warns as simulate() does.
void warn_of_robots(const RunDriver& driver, const Scenario& scenario) {
  if (driver.design) warn_of_robot(*driver.design, scenario.modelled_robot());
}

py::array_t<double> measure_each(const std::vector<const Scenario*>& scenarios,
                                 const py::list& drivers, int threads, bool warns) {
  std::vector<RunDriver> own;
  for (const py::handle& driver : drivers) own.push_back(driver_from(driver));
  for (const RunDriver& driver : own) {
    for (const Scenario* scenario : scenarios) {
      if (warns) warn_of_robots(driver, *scenario);
    }
  }
  std::vector<RunFigures> figures(own.size() * scenarios.size());
  watched([&] {
    ThreadPool pool(threads);
    measure_runs(scenarios, own, figures.data(), pool);
  });
  return rows_of(
      figures, {static_cast<py::ssize_t>(own.size()), static_cast<py::ssize_t>(scenarios.size())});
}

py::array_t<double> measure_seeds(const Scenario& scenario, const py::object& driver,
                                  const std::vector<std::uint64_t>& seeds, int threads) {
  const RunDriver own = driver_from(driver);
  warn_of_robots(own, scenario);
  std::vector<RunFigures> figures(seeds.size());
  watched([&] {
    ThreadPool pool(threads);
    measure_draws(scenario, own, seeds.data(), static_cast<std::ptrdiff_t>(seeds.size()),
                  figures.data(), pool);
  });
  return rows_of(figures, {static_cast<py::ssize_t>(seeds.size())});
}

// The mean of the worst share of each row's values, (n, scenarios), as a tuning counts costs; caps
// as FamilyCost has them.
py::array_t<double> family_mean(const RowPoints& values, double share,
                                const std::vector<double>& caps) {
  const FamilyCost family(share, caps);
  if (!caps.empty() && static_cast<Eigen::Index>(caps.size()) != values.cols()) {
    throw py::value_error("caps must be as many as values has columns");
  }
  py::array_t<double> result(values.rows());
  double* const means = result.mutable_data();
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    Eigen::VectorXd row = values.row(i);
    family.see(row);
    means[i] = dot(row, worst_share_weights(row, share));
  }
  return result;
}

}  // namespace

void bind_measured_runs(py::module_& module) {
  py::tuple names = py::cast(RunFigures::names());
  module.attr("FIGURES") = names;
  module.attr("SETTLED_WITHIN") = settled_within;
  module.def("family_mean", &family_mean, Computes(), py::arg("values"), py::arg("worst_share"),
             py::arg("caps"));
  module.def("measure_runs", &measure_each, py::arg("scenarios"), py::arg("drivers"),
             py::arg("threads"), py::arg("warns") = true,
             "measure_runs(scenarios, drivers, threads, warns=True)\n--\n\n(drivers, scenarios, "
             "FIGURES): each Controller or Rival on each Scenario.");
  module.def("measure_draws", &measure_seeds, py::arg("scenario"), py::arg("driver"),
             py::arg("seeds"), py::arg("threads"),
             "measure_draws(scenario, driver, seeds, threads)\n--\n\n(n, FIGURES): a Controller or "
             "Rival on a Scenario with n seeds of its noise.");
}

}  // namespace nfopidn::python
