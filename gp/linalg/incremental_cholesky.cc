#include "gp/linalg/incremental_cholesky.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <new>
#include <utility>

#include "absl/strings/str_format.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/not_positive_definite.h"
#include "gp/linalg/row_removal.h"
#include "gp/linalg/tile_operations.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kMinimumCapacity = 64;
constexpr int64_t kCornerTile = 64;

absl::Status RefusedPivot(int64_t row) {
  return NotPositiveDefinite(absl::StrFormat(
      "row %d: pivot not above its floor, the matrix is not positive definite to working "
      "precision; drop the row (a duplicate?) or add noise to the diagonal",
      row));
}

absl::StatusOr<AlignedMatrix> ZeroMatrix(int64_t size) {
  AlignedMatrix matrix;
  try {
    matrix = AlignedMatrix(size, size);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("no memory for a factor of %d rows (%.1f GB)", size, 8e-9 * size * size));
  }
  constexpr int64_t kRowsPerTask = 256;
  kernels::ParallelFor((size + kRowsPerTask - 1) / kRowsPerTask, 4.0 * size * size, [&](int64_t t) {
    const int64_t end = std::min(size, (t + 1) * kRowsPerTask);
    std::fill(matrix.row(t * kRowsPerTask), matrix.row(end), 0.0);
  });
  return matrix;
}

// S := K22 - X X^T in the lower triangle (and above it within the diagonal tiles).
void SubtractGram(ConstMatrixView<double> x, MatrixView<double> s) {
  const auto subtract = [&](int64_t row, int64_t column, int64_t rows, int64_t columns) {
    tile::SubtractProductTransposed(tile::Block(x, row, 0, rows, x.cols),
                                    tile::Block(x, column, 0, columns, x.cols),
                                    tile::Block(s, row, column, rows, columns));
  };
  ForEachLowerTile(x.rows, kCornerTile, 1.0 * x.rows * x.rows * x.cols, subtract);
}

}  // namespace

absl::Status CheckRows(absl::Span<const int64_t> rows, int64_t size) {
  for (size_t i = 0; i < rows.size(); ++i) {
    EGOSIEVE_REQUIRE(
        InvalidArgument, rows[i] >= 0 && rows[i] < size && (i == 0 || rows[i] > rows[i - 1]),
        "rows[%d] = %d; rows must be strictly increasing and in [0, %d)", i, rows[i], size);
  }
  return absl::OkStatus();
}

ConstMatrixView<double> IncrementalCholesky::Factor() const { return factor_->block(size_, size_); }

IncrementalCholesky::Kept IncrementalCholesky::Keep() const {
  kept_ = std::max(kept_, size_);
  return {factor_, Factor()};
}

void IncrementalCholesky::Take(AlignedMatrix factor) {
  factor_ = std::make_shared<AlignedMatrix>(std::move(factor));
  kept_ = 0;
}

absl::Status IncrementalCholesky::LeaveToHolders(int64_t first) {
  if (first >= kept_) return absl::OkStatus();
  if (factor_.use_count() == 1) {
    std::atomic_thread_fence(std::memory_order_acquire);  // after the last holder's reads
    kept_ = 0;
    return absl::OkStatus();
  }
  return Reallocate(factor_->rows());
}

absl::Status IncrementalCholesky::Reallocate(int64_t rows) {
  EGOSIEVE_ASSIGN_OR_RETURN(AlignedMatrix memory, ZeroMatrix(rows));
  for (int64_t i = 0; i < size_; ++i) {
    std::copy(factor_->row(i), factor_->row(i) + i + 1, memory.row(i));
  }
  Take(std::move(memory));
  return absl::OkStatus();
}

absl::Status IncrementalCholesky::Factorize(
    int64_t n, absl::FunctionRef<absl::Status(MatrixView<double>)> fill) {
  return Adopt(n, [&](MatrixView<double> a) -> absl::StatusOr<int64_t> {
    EGOSIEVE_RETURN_IF_ERROR(fill(a));
    return FactorizeInParallel(a, PivotFloors(a, n, 1.0));
  });
}

absl::Status IncrementalCholesky::Adopt(
    int64_t n, absl::FunctionRef<absl::StatusOr<int64_t>(MatrixView<double>)> factorize) {
  EGOSIEVE_ASSIGN_OR_RETURN(AlignedMatrix fresh,
                            ZeroMatrix(std::max({n, factor_->rows(), least_capacity_})));
  EGOSIEVE_ASSIGN_OR_RETURN(const int64_t bad, factorize(fresh.block(n, n)));
  if (bad >= 0) return RefusedPivot(bad);
  Take(std::move(fresh));
  size_ = n;
  return absl::OkStatus();
}

absl::Status IncrementalCholesky::Append(ConstMatrixView<double> below,
                                         ConstMatrixView<double> corner) {
  const int64_t n = size_;
  const int64_t k = corner.rows;
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckShape("below", below, k, n));
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckShape("corner", corner, k, k));
  if (n + k > factor_->rows()) {
    EGOSIEVE_RETURN_IF_ERROR(
        Reallocate(std::max({n + k, factor_->rows() + factor_->rows() / 4, kMinimumCapacity})));
  }
  EGOSIEVE_RETURN_IF_ERROR(LeaveToHolders(n));
  const MatrixView<double> whole = factor_->block(n + k, n + k);
  const MatrixView<double> x = tile::Block(whole, n, 0, k, n);
  const MatrixView<double> s = tile::Block(whole, n, n, k, k);
  for (int64_t i = 0; i < k; ++i) {
    std::copy(below.row(i), below.row(i) + n, x.row(i));
    std::copy(corner.row(i), corner.row(i) + i + 1, s.row(i));
  }
  const std::vector<double> floors = PivotFloors(s, n + k, 1.0);
  AppendRows(Factor(), x);
  SubtractGram(x, s);
  const int64_t bad = FactorizeInParallel(s, floors);
  if (bad >= 0) return RefusedPivot(n + bad);
  size_ = n + k;
  return absl::OkStatus();
}

absl::Status IncrementalCholesky::Remove(absl::Span<const int64_t> rows) {
  EGOSIEVE_RETURN_IF_ERROR(CheckRows(rows, size_));
  EGOSIEVE_RETURN_IF_ERROR(LeaveToHolders(rows.empty() ? size_ : rows[0]));
  RemoveRows(factor_->block(size_, size_), rows);
  size_ -= static_cast<int64_t>(rows.size());
  return absl::OkStatus();
}

double IncrementalCholesky::LogDeterminant() const {
  double sum = 0.0;
  for (int64_t i = 0; i < size_; ++i) sum += std::log(factor_->row(i)[i]);
  return 2.0 * sum;
}

absl::StatusOr<std::vector<double>> IncrementalCholesky::InverseDiagonal(
    absl::Span<const int64_t> rows) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckRows(rows, size_));
  std::vector<double> diagonal(rows.size());
  InverseColumnNorms(Factor(), rows, absl::MakeSpan(diagonal));
  return diagonal;
}

bool IncrementalCholesky::RefactoringIsCheaper(absl::Span<const int64_t> rows) const {
  double removal = 0.0;
  for (const int64_t row : rows) {
    const double below = static_cast<double>(size_ - row);
    removal += 2.0 * below * below;
  }
  const double left = static_cast<double>(size_ - static_cast<int64_t>(rows.size()));
  return left * left * left / 3.0 < removal;
}

}  // namespace egosieve::gp
