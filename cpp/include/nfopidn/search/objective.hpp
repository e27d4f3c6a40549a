// L3. What is searched for the minimum of.
#pragma once

#include <limits>

#include "nfopidn/search/box.hpp"

namespace nfopidn {

// What is minimised. Optimisers know nothing else of it. What takes long asks the Interruption of
// its thread whether to stop; its answers are then thrown away.
class Objective {
 public:
  virtual ~Objective() = default;
  virtual void costs(const Points& points, double* costs) = 0;
  // The same for a caller to whom all costs over a bound of theirs are one.
  virtual void bounded_costs(const Points& points, const double* /*bounds*/, double* costs) {
    this->costs(points, costs);
  }
  // Whether there are gradients, and whether points evaluated in vain cost next to nothing.
  virtual bool has_gradient() const { return false; }
  virtual bool is_cheap() const { return false; }
  // Points to be asked for at once, at most: what is asked for together is recorded together.
  virtual Eigen::Index most_at_once() const { return std::numeric_limits<Eigen::Index>::max(); }
  // Partial derivatives to be asked for at once, at most: between two askings a search may end.
  virtual Eigen::Index partials_at_once() const { return std::numeric_limits<Eigen::Index>::max(); }
  // The cost, and its partial derivatives by the coordinates first .. first + count - 1. All of
  // them, a gradient, count as 1 + dimension evaluations.
  virtual double partials(const Point& /*point*/, Eigen::Index /*first*/, Eigen::Index /*count*/,
                          double* /*slopes*/) {
    return 0;
  }
};

}  // namespace nfopidn
