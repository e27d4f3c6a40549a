// Objectives whose costs Python code gives: a function of the user's, or an engine.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "nfopidn/search/objective.hpp"

namespace nfopidn::python {

using RowPoints = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// What Python code has raised, with the lines that it came from.
inline py::object raised_by(const py::error_already_set& error) {
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

  void costs(const Points& points, double* costs) override { ask(points, nullptr, costs); }

  py::object raised = py::none();

 protected:
  // `bounds` may be null.
  virtual py::object call(const py::function& function, const RowPoints& rows,
                          const double* /*bounds*/) const {
    return function(rows);
  }

  void ask(const Points& points, const double* bounds, double* costs) {
    const py::gil_scoped_acquire acquire;
    std::fill(costs, costs + points.cols(), std::numeric_limits<double>::quiet_NaN());
    if (!raised.is_none()) return;
    try {
      const auto reply =
          call(function_, points.transpose(), bounds)
              .cast<py::array_t<double, py::array::c_style | py::array::forcecast>>();
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

// An objective of the core whose costs are computed elsewhere: a Python function of a stage's name,
// points (n, p) and bounds (n,) or None hands them to workers. Gradients are computed here.
class EngineObjective : public FunctionObjective {
 public:
  EngineObjective(py::function function, int workers, std::string stage, Objective& local)
      : FunctionObjective(std::move(function), most(local, workers)),
        stage_(std::move(stage)),
        local_(local) {}

  void bounded_costs(const Points& points, const double* bounds, double* costs) override {
    ask(points, bounds, costs);
  }
  bool has_gradient() const override { return local_.has_gradient(); }
  bool is_cheap() const override { return local_.is_cheap(); }
  Eigen::Index partials_at_once() const override { return local_.partials_at_once(); }
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override {
    return local_.partials(point, first, count, slopes);
  }

 protected:
  py::object call(const py::function& function, const RowPoints& rows,
                  const double* bounds) const override {
    const py::object given = bounds == nullptr
                                 ? py::object(py::none())
                                 : py::object(py::array_t<double>(rows.rows(), bounds));
    return function(stage_, rows, given);
  }

 private:
  static Eigen::Index most(const Objective& local, int workers) {
    const Eigen::Index own = local.most_at_once();
    const Eigen::Index all = std::numeric_limits<Eigen::Index>::max();
    return own > all / workers ? all : own * workers;
  }

  std::string stage_;
  Objective& local_;
};

}  // namespace nfopidn::python
