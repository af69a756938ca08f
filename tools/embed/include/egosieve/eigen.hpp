/**
 * @file eigen.hpp
 * Views of Eigen's matrices, maps and blocks, in either storage order, without a copy.
 *
 *     Eigen::MatrixXd x(n, d);
 *     Eigen::VectorXf mean(m);
 *     gp.Condition(egosieve::View(x), egosieve::View(y));
 *     gp.Predict(egosieve::View(queries), {egosieve::MutableView(mean)});
 */
#ifndef EGOSIEVE_EIGEN_HPP_
#define EGOSIEVE_EIGEN_HPP_

#include <Eigen/Core>

#include "arrays.hpp"

namespace egosieve {

/** A view to read from. Expressions without memory of their own do not compile. */
template <typename Derived>
ConstArray View(const Eigen::DenseBase<Derived>& matrix) {
  static_assert((Derived::Flags & Eigen::DirectAccessBit) != 0,
                "an expression has no memory to view: evaluate it into a matrix first");
  const Derived& derived = matrix.derived();
  const int64_t outer = derived.outerStride(), inner = derived.innerStride();
  return Derived::IsRowMajor
             ? ConstArray(derived.data(), derived.rows(), derived.cols(), outer, inner)
             : ConstArray(derived.data(), derived.rows(), derived.cols(), inner, outer);
}

/** A view to write to. */
template <typename Derived>
Array MutableView(Eigen::DenseBase<Derived>& matrix) {
  static_assert((Derived::Flags & Eigen::DirectAccessBit) != 0,
                "an expression has no memory to write to");
  Derived& derived = matrix.derived();
  const int64_t outer = derived.outerStride(), inner = derived.innerStride();
  return Derived::IsRowMajor ? Array(derived.data(), derived.rows(), derived.cols(), outer, inner)
                             : Array(derived.data(), derived.rows(), derived.cols(), inner, outer);
}

/** The same for temporary maps and blocks. */
template <typename Derived>
Array MutableView(Eigen::DenseBase<Derived>&& matrix) {
  return MutableView(matrix);
}

}  // namespace egosieve

#endif  // EGOSIEVE_EIGEN_HPP_
