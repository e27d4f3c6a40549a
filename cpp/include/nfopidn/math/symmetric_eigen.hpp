// L3. Eigenvalues and eigenvectors of a symmetric matrix: Householder's reduction to a tridiagonal
// one, then implicit QR steps with Wilkinson's shift (G. Golub and C. Van Loan, Matrix
// Computations, sections 8.3.1 and 8.3.2).
//
// All sums are plain loops in a fixed order, so that the result has the same bits on every
// processor. Eigen's own solver sums in the order of the processor's vectors.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace nfopidn {

class SymmetricEigen {
 public:
  // Reads the lower half of `matrix`, whose elements must be finite.
  void decompose(const Eigen::MatrixXd& matrix) {
    rest_ = matrix;
    reduce();
    accumulate();
    diagonalise();
  }

  const Eigen::VectorXd& values() const { return diagonal_; }  // in no order
  const Eigen::MatrixXd& vectors() const { return vectors_; }  // a column a vector

 private:
  // Reflections make all elements zero but the diagonal and its neighbours. The vectors of the
  // reflections stay in the columns of `rest_`, below the diagonal.
  void reduce() {
    const Eigen::Index n = rest_.rows();
    diagonal_.resize(n);
    beside_.setZero(n);
    scale_.setZero(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      diagonal_(k) = rest_(k, k);
      if (k + 2 < n) {
        reflect(k);
      } else if (k + 1 < n) {
        beside_(k) = rest_(k + 1, k);
      }
    }
  }

  // Reflects column k onto its first element below the diagonal, and the rest of the matrix with
  // it: A - v w' - w v'.
  void reflect(Eigen::Index k) {
    const Eigen::Index n = rest_.rows(), first = k + 1;
    double* const __restrict v = rest_.col(k).data();
    double below = 0;
    for (Eigen::Index i = first + 1; i < n; ++i) below += v[i] * v[i];
    beside_(k) = v[first];
    if (!(below > 0)) return;
    const double length = std::sqrt(v[first] * v[first] + below);
    beside_(k) = v[first] > 0 ? -length : length;
    v[first] -= beside_(k);
    scale_(k) = 2 / (v[first] * v[first] + below);
    multiply(first, v);
    double along = 0;
    for (Eigen::Index i = first; i < n; ++i) along += work_(i) * v[i];
    along *= scale_(k) / 2;
    double* const __restrict w = work_.data();
    for (Eigen::Index i = first; i < n; ++i) w[i] = scale_(k) * (w[i] - along * v[i]);
    for (Eigen::Index j = first; j < n; ++j) {
      const double vj = v[j], wj = w[j];
      double* const __restrict column = rest_.col(j).data();
      for (Eigen::Index i = j; i < n; ++i) column[i] -= v[i] * wj + w[i] * vj;
    }
  }

  // work = A v for the rows and columns from `first` on, from A's lower half.
  void multiply(Eigen::Index first, const double* __restrict v) {
    const Eigen::Index n = rest_.rows();
    work_.setZero(n);
    double* const __restrict product = work_.data();
    for (Eigen::Index j = first; j < n; ++j) {
      const double* const __restrict column = rest_.col(j).data();
      const double vj = v[j];
      double sum = column[j] * vj;
      for (Eigen::Index i = j + 1; i < n; ++i) {
        product[i] += column[i] * vj;
        sum += column[i] * v[i];
      }
      product[j] += sum;
    }
  }

  // The product of the reflections, from the last to the first.
  void accumulate() {
    const Eigen::Index n = rest_.rows();
    vectors_.setIdentity(n, n);
    for (Eigen::Index k = n - 3; k >= 0; --k) {
      if (scale_(k) == 0) continue;
      const double* const __restrict v = rest_.col(k).data();
      for (Eigen::Index j = k + 1; j < n; ++j) {
        double* const __restrict column = vectors_.col(j).data();
        double along = 0;
        for (Eigen::Index i = k + 1; i < n; ++i) along += v[i] * column[i];
        along *= scale_(k);
        for (Eigen::Index i = k + 1; i < n; ++i) column[i] -= along * v[i];
      }
    }
  }

  void diagonalise() {
    constexpr double rounding = 0x1p-52;
    const Eigen::Index n = diagonal_.size();
    Eigen::Index last = n - 1;
    // Two steps a value are usual; the limit is for elements that are not finite.
    for (Eigen::Index steps = 0; last > 0 && steps < 60 * n; ++steps) {
      for (Eigen::Index i = 0; i < last; ++i) {
        const double near = std::fabs(diagonal_(i)) + std::fabs(diagonal_(i + 1));
        if (std::fabs(beside_(i)) <= rounding * near) beside_(i) = 0;
      }
      while (last > 0 && beside_(last - 1) == 0) --last;
      if (last == 0) break;
      Eigen::Index first = last - 1;
      while (first > 0 && beside_(first - 1) != 0) --first;
      step(first, last);
    }
  }

  // An implicit QR step on the rows from `first` to `last`.
  void step(Eigen::Index first, Eigen::Index last) {
    const double half = (diagonal_(last - 1) - diagonal_(last)) / 2, corner = beside_(last - 1);
    const double root = std::sqrt(half * half + corner * corner);
    const double shift = diagonal_(last) - corner * corner / (half < 0 ? half - root : half + root);
    double x = diagonal_(first) - shift, z = beside_(first);
    for (Eigen::Index k = first; k < last; ++k) {
      const double length = std::sqrt(x * x + z * z);
      const double c = length > 0 ? x / length : 1, s = length > 0 ? z / length : 0;
      if (k > first) beside_(k - 1) = length;
      const double a = diagonal_(k), b = diagonal_(k + 1), off = beside_(k);
      diagonal_(k) = c * c * a + 2 * c * s * off + s * s * b;
      diagonal_(k + 1) = s * s * a - 2 * c * s * off + c * c * b;
      beside_(k) = (c * c - s * s) * off + c * s * (b - a);
      x = beside_(k);
      if (k + 1 < last) {
        z = s * beside_(k + 1);
        beside_(k + 1) *= c;
      }
      turn(k, c, s);
    }
  }

  void turn(Eigen::Index k, double c, double s) {
    double* const __restrict one = vectors_.col(k).data();
    double* const __restrict other = vectors_.col(k + 1).data();
    for (Eigen::Index i = 0; i < vectors_.rows(); ++i) {
      const double before = one[i];
      one[i] = c * before + s * other[i];
      other[i] = c * other[i] - s * before;
    }
  }

  Eigen::VectorXd diagonal_, beside_;  // of the tridiagonal matrix
  Eigen::MatrixXd vectors_, rest_;
  Eigen::VectorXd scale_;  // 2 / v'v of each reflection; 0: none
  Eigen::VectorXd work_;
};

}  // namespace nfopidn
