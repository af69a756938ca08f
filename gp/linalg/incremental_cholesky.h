// Cholesky factor of a symmetric positive definite matrix that grows and shrinks by blocks of rows,
// for an online Gaussian process that adds observations and drops old ones.
//
// K is the n x n matrix being factored (covariances plus noise), L its lower factor, K = L L^T,
// L(i,i) > 0, in float64. K itself is not kept.
//
//   operation                       cost (flops)                     equation
//   Append, k rows                  k n^2 + k^2 n + k^3/3            (A1)-(A2)
//   Remove, k rows, first row i     2 k (n - i)^2                    (IC1)-(IC3)
//   Factorize                       n^3 / 3
//
//   (A1) X = K21 L^-T,  S = K22 - X X^T
//   (A2) S = M M^T                              the new rows of the factor are [X, M]
//   (IC1) L33' L33'^T = L33 L33^T + L32 L32^T   2: removed rows, 3: rows below; a positive update,
//                                               which cannot fail
//   (IC2) [L33, L32] = [L33', 0] Q              an LQ factorisation by Householder reflectors
//   (IC3) Q = prod_p (I - V_p T_p V_p^T)        compact WY form, one panel of columns p at a time:
//                                               outside the panels all is matrix multiplication
//
// The remaining rows keep their order. The library's threads share the work in tiles whose
// arithmetic does not depend on the number of threads: results are the same bits for any thread
// count.
//
// References: Rasmussen & Williams (2006), A.4; Golub & Van Loan, 4th ed., 5.2.3, 6.5; Schreiber &
// Van Loan (1989), "A storage-efficient WY representation".
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/linalg/aligned_matrix.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

// InvalidArgument unless rows are strictly increasing and in [0, size).
absl::Status CheckRows(absl::Span<const int64_t> rows, int64_t size);

class IncrementalCholesky {
 public:
  // least_capacity: rows to allocate memory for at the start.
  explicit IncrementalCholesky(int64_t least_capacity = 0) : least_capacity_(least_capacity) {}

  IncrementalCholesky(IncrementalCholesky&&) = default;
  IncrementalCholesky& operator=(IncrementalCholesky&&) = default;

  int64_t size() const { return size_; }
  int64_t capacity() const { return factor_->rows(); }

  // L: n x n, row-major; elements above the diagonal are zero. Valid until the next change.
  kernels::ConstMatrixView<double> Factor() const;

  // The present factor for as long as its holder wants it: L as above, and the memory in which it
  // lies. It costs nothing, except that a later change of these rows works on a copy (n^2).
  struct Kept {
    std::shared_ptr<const AlignedMatrix> memory;
    kernels::ConstMatrixView<double> factor;
  };
  Kept Keep() const;

  // The functions that grow the factor give ResourceExhausted, with the factor unchanged, if the
  // memory is not available.

  // Replaces the factor by that of the n x n matrix whose lower triangle `fill` writes into the
  // factor's memory. FailedPrecondition, with the row, if a pivot (square of L(i,i)) is NaN or not
  // above max(n, 1) eps K(i,i), the size of the rounding error there: the matrix is singular to
  // working precision. The factor is then unchanged. An error of `fill` is returned as it is.
  absl::Status Factorize(int64_t n,
                         absl::FunctionRef<absl::Status(kernels::MatrixView<double>)> fill);

  // Replaces the factor by the output of `factorize`: the lower triangle of an n x n matrix of
  // zeros. `factorize` returns -1, or the row whose pivot it refused (FailedPrecondition as above).
  absl::Status Adopt(
      int64_t n, absl::FunctionRef<absl::StatusOr<int64_t>(kernels::MatrixView<double>)> factorize);

  // Appends k rows. below: k x n, K21; corner: k x k, K22, lower triangle read. FailedPrecondition
  // as for Factorize, with the row of the whole matrix; the factor is then unchanged.
  absl::Status Append(kernels::ConstMatrixView<double> below,
                      kernels::ConstMatrixView<double> corner);

  // Removes the rows (and columns) of K with these indices, which must be in [0, n) and strictly
  // increasing (otherwise InvalidArgument, unchanged). std::bad_alloc also leaves it unchanged, and
  // so does ResourceExhausted for the copy of a kept factor.
  absl::Status Remove(absl::Span<const int64_t> rows);

  // Drops the rows from `size` on, as if they had not been appended; size in [0, n].
  void Truncate(int64_t size) { size_ = size; }

  // log |K| = 2 sum_i log L(i,i).
  double LogDeterminant() const;

  // [K^-1]_rr for the given rows, by column norms of L^-1 (n^3 / 3 flops for all rows, in panels:
  // no n x n array is needed).
  absl::StatusOr<std::vector<double>> InverseDiagonal(absl::Span<const int64_t> rows) const;

  // True if removing `rows` from this factor costs more operations than factorising the remaining
  // matrix, given that matrix.
  bool RefactoringIsCheaper(absl::Span<const int64_t> rows) const;

 private:
  // Before a change of the rows from `first` on: takes a copy of the factor if they are kept.
  absl::Status LeaveToHolders(int64_t first);
  // Moves to other memory, of `rows` rows.
  absl::Status Reallocate(int64_t rows);
  void Take(AlignedMatrix factor);

  int64_t least_capacity_;
  int64_t size_ = 0;
  // capacity x capacity; its strict upper triangle is zero.
  std::shared_ptr<AlignedMatrix> factor_ = std::make_shared<AlignedMatrix>();
  mutable int64_t kept_ = 0;  // rows that holders of this memory may read
};

}  // namespace egosieve::gp
