// Cholesky factor of a symmetric positive definite matrix that grows and shrinks by blocks of rows:
// what an online Gaussian process needs when observations arrive and old ones are dropped.
//
// K is the n x n matrix being factored (covariances plus noise), L its lower factor, K = L L^T,
// L(i,i) > 0, in float64. K itself is not kept.
//
//   operation                       cost (flops)                     equation
//   Append, k rows                  k n^2 + k^2 n + k^3/3            (A1)-(A2)
//   Remove, k rows, first row i     2 k (n - i)^2                    (IC1)-(IC3)
//   Factorize                       n^3 / 3
//   Solve, c columns                2 c n^2
//   HalfSolve, c columns            c n^2
//
//   (A1) X = K21 L^-T,  S = K22 - X X^T
//   (A2) S = M M^T                              the new rows of the factor are [X, M]
//   (IC1) L33' L33'^T = L33 L33^T + L32 L32^T   2: removed rows, 3: rows below; a positive update:
//                                               it cannot fail
//   (IC2) [L33, L32] = [L33', 0] Q              an LQ factorisation by Householder reflectors
//   (IC3) Q = prod_p (I - V_p T_p V_p^T)        compact WY form, a panel of columns p at a time:
//                                               everything but the panels is matrix multiplication
//
// The rows that remain keep their order. Work is shared among the library's threads in tiles whose
// arithmetic does not depend on how many there are: results are the same bits for any thread count.
//
// References: Rasmussen & Williams (2006), A.4; Golub & Van Loan, 4th ed., 5.2.3, 6.5; Schreiber &
// Van Loan (1989), "A storage-efficient WY representation".
#ifndef EGOSIEVE_GP_LINALG_INCREMENTAL_CHOLESKY_H_
#define EGOSIEVE_GP_LINALG_INCREMENTAL_CHOLESKY_H_

#include <cstdint>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/linalg/aligned_matrix.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

struct IncrementalCholeskyOptions {
  // A pivot (square of L(i,i)) must exceed this multiple of max(n, 1) eps K(i,i), the size of what
  // rounding leaves there; smaller ones mean a matrix that is singular to working precision.
  double pivot_floor = 1.0;
  // Rows that there is room for from the first on.
  int64_t least_capacity = 0;
};

class IncrementalCholesky {
 public:
  explicit IncrementalCholesky(const IncrementalCholeskyOptions& options = {})
      : options_(options) {}

  IncrementalCholesky(IncrementalCholesky&&) = default;
  IncrementalCholesky& operator=(IncrementalCholesky&&) = default;
  // A copy of its own, n^2 in size: never made by accident.
  absl::StatusOr<IncrementalCholesky> Clone() const;

  int64_t size() const { return size_; }
  int64_t capacity() const { return factor_.rows(); }

  // L: n x n, row-major; elements above the diagonal are zero. Valid until the next change.
  kernels::ConstMatrixView<double> Factor() const;

  // Room for `rows` rows without another allocation. ResourceExhausted, unchanged, where the memory
  // is not to be had; so too from the functions that grow the factor.
  absl::Status Reserve(int64_t rows);

  // Replaces the factor by that of `k` (n x n, lower triangle read). FailedPrecondition, naming the
  // row, where a pivot is under the floor or not a number; the factor is then unchanged.
  absl::Status Factorize(kernels::ConstMatrixView<double> k);
  // The same for a matrix that `fill` writes (its lower triangle) straight to where it is factored.
  // An error of `fill` is returned as it is.
  absl::Status Factorize(int64_t n,
                         absl::FunctionRef<absl::Status(kernels::MatrixView<double>)> fill);

  // Replaces the factor by what `factorize` writes: the lower triangle of an n x n matrix of zeros.
  // It returns the row whose pivot it refused (FailedPrecondition as above) or -1.
  absl::Status Adopt(
      int64_t n, absl::FunctionRef<absl::StatusOr<int64_t>(kernels::MatrixView<double>)> factorize);

  // Appends k rows. below: k x n, K21; corner: k x k, K22, lower triangle read. FailedPrecondition,
  // naming the row of the whole matrix, as for Factorize; the factor is then unchanged.
  absl::Status Append(kernels::ConstMatrixView<double> below,
                      kernels::ConstMatrixView<double> corner);

  // Removes the rows (and columns) of K with these indices, which must be in [0, n), strictly
  // increasing (InvalidArgument otherwise, unchanged).
  absl::Status Remove(absl::Span<const int64_t> rows);

  // Forgets the rows from `size` on, as if they had not been appended; size in [0, n].
  void Truncate(int64_t size) { size_ = size; }
  void Clear() { Truncate(0); }

  // B := K^-1 B, B: n x c. InvalidArgument on other shapes.
  absl::Status Solve(kernels::MatrixView<double> b) const;
  // B := L^-1 B.
  absl::Status HalfSolve(kernels::MatrixView<double> b) const;
  // B := L^-T B.
  absl::Status HalfSolveTransposed(kernels::MatrixView<double> b) const;

  // log |K| = 2 sum_i log L(i,i).
  double LogDeterminant() const;

  // [K^-1]_rr for the rows given, by column norms of L^-1 (n^3 / 3 flops for all rows, in panels:
  // no n x n array is made).
  absl::Status InverseDiagonal(absl::Span<const int64_t> rows, absl::Span<double> out) const;

  // True where removing `rows` from this factor costs more than factorising what is left would,
  // the matrix being at hand: a comparison of operation counts.
  bool RefactoringIsCheaper(absl::Span<const int64_t> rows) const;

 private:
  IncrementalCholeskyOptions options_;
  int64_t size_ = 0;
  AlignedMatrix factor_;  // capacity x capacity; all of its strict upper triangle is zero
};

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_LINALG_INCREMENTAL_CHOLESKY_H_
