// L3. Sums and products in an order of their own. Eigen's depend on the processor's vectors, on
// whether it has fused multiply-add, and on Eigen's version; a search that compares costs to the
// last bit would end elsewhere.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace nfopidn {

// term(0) + ... + term(count - 1), as Eigen 3.4 sums on vectors of two: four partial sums, those of
// even and odd places apart. Value is double, or a vector of them for several sums at once.
template <class Value, class Term>
Value sum_of(Eigen::Index count, const Term& term) {
  const Eigen::Index even = count - count % 2;
  const Eigen::Index fours = count - count % 4;
  if (count == 0) return Value{};
  if (even == 0) return term(0);
  Value first = term(0), second = term(1);
  if (even > 2) {
    Value third = term(2), fourth = term(3);
    for (Eigen::Index i = 4; i < fours; i += 4) {
      first += term(i);
      second += term(i + 1);
      third += term(i + 2);
      fourth += term(i + 3);
    }
    first += third;
    second += fourth;
    if (even > fours) {
      first += term(fours);
      second += term(fours + 1);
    }
  }
  first += second;
  return even < count ? first + term(even) : first;
}

// Of vectors and arrays, and of expressions that give one.
template <class Vector>
double sum(const Vector& a) {
  return sum_of<double>(a.size(), [&](Eigen::Index i) { return a.coeff(i); });
}
template <class Vector>
double mean(const Vector& a) {
  return sum(a) / static_cast<double>(a.size());
}
template <class Left, class Right>
double dot(const Left& a, const Right& b) {
  return sum_of<double>(a.size(), [&](Eigen::Index i) { return a.coeff(i) * b.coeff(i); });
}
template <class Vector>
double squared_norm(const Vector& a) {
  return sum_of<double>(a.size(), [&](Eigen::Index i) {
    const double number = a.coeff(i);
    return number * number;
  });
}
template <class Vector>
double norm(const Vector& a) {
  return std::sqrt(squared_norm(a));
}

// matrix * vector, column after column.
inline Eigen::VectorXd product(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& vector) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(matrix.rows());
  for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) result(i) += matrix(i, j) * vector(j);
  }
  return result;
}

// The place of the least number, the first of equals. NaN is never less.
template <class Vector>
Eigen::Index place_of_least(const Vector& a) {
  Eigen::Index least = 0;
  for (Eigen::Index i = 1; i < a.size(); ++i) {
    if (a.coeff(i) < a.coeff(least)) least = i;
  }
  return least;
}

}  // namespace nfopidn
