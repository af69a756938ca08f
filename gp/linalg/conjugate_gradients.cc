#include "gp/linalg/conjugate_gradients.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_format.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/not_positive_definite.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr double kInnerShare = 0.5;     // of the tolerance, where (CG1) stops
constexpr double kLeastProgress = 0.5;  // of a new start's residual

// Packed, k x n.
struct Rows {
  std::vector<double> values;
  MatrixView<double> view;

  explicit Rows(ConstMatrixView<double> like)
      : values(like.rows * like.cols), view(values.data(), like.rows, like.cols) {}
};

struct Solver {
  LinearMap multiply, precondition;
  const ConjugateGradientOptions& options;
  ConstMatrixView<double> b;
  MatrixView<double> x;
  std::vector<double> sizes;  // |b_c|
  Rows residual, direction, image, preconditioned;
  int64_t iterations = 0;

  Solver(LinearMap multiply, LinearMap precondition, const ConjugateGradientOptions& options,
         ConstMatrixView<double> b, MatrixView<double> x)
      : multiply(multiply),
        precondition(precondition),
        options(options),
        b(b),
        x(x),
        residual(b),
        direction(b),
        image(b),
        preconditioned(b) {
    for (int64_t c = 0; c < b.rows; ++c) {
      sizes.push_back(std::sqrt(Square(b.row(c), b.cols)));
      if (sizes[c] == 0.0) std::fill_n(x.row(c), x.cols, 0.0);
    }
  }

  bool IsWithin(int64_t c, double limit) const {
    return std::sqrt(Square(residual.view.row(c), b.cols)) <= limit * sizes[c];
  }

  // r := b - A x; gives the largest |r| / |b|.
  absl::StatusOr<double> TrueResidual() {
    if (std::all_of(x.data, x.data + x.rows * x.cols, [](double v) { return v == 0.0; })) {
      std::fill(residual.values.begin(), residual.values.end(), 0.0);
    } else {
      EGOSIEVE_RETURN_IF_ERROR(multiply(x, residual.view));
    }
    double largest = 0.0;
    for (int64_t c = 0; c < b.rows; ++c) {
      double* r = residual.view.row(c);
      for (int64_t i = 0; i < b.cols; ++i) r[i] = b(c, i) - r[i];
      const double size = std::sqrt(Square(r, b.cols));
      if (size == 0.0) continue;
      largest = std::max(largest, std::isfinite(size) ? size / sizes[c] : HUGE_VAL);
    }
    return largest;
  }

  // (CG1) from r.
  absl::Status Iterate() {
    EGOSIEVE_RETURN_IF_ERROR(precondition(residual.view, direction.view));
    std::vector<double> products(b.rows);  // r.z, or 0 for a column that has ended
    for (int64_t c = 0; c < b.rows; ++c) {
      products[c] = Dot(residual.view.row(c), direction.view.row(c), b.cols);
    }
    while (iterations < options.iterations) {
      bool goes_on = false;
      for (int64_t c = 0; c < b.rows; ++c) {
        if (!(products[c] > 0.0) || IsWithin(c, kInnerShare * options.tolerance)) products[c] = 0.0;
        goes_on |= products[c] > 0.0;
      }
      if (!goes_on) break;
      EGOSIEVE_RETURN_IF_ERROR(multiply(direction.view, image.view));
      ++iterations;
      for (int64_t c = 0; c < b.rows; ++c) {
        const double *p = direction.view.row(c), *q = image.view.row(c);
        const double step = products[c] / Dot(p, q, b.cols);
        if (!(step > 0.0 && std::isfinite(step))) products[c] = 0.0;
        if (products[c] == 0.0) continue;
        double *to = x.row(c), *r = residual.view.row(c);
        for (int64_t i = 0; i < b.cols; ++i) to[i] += step * p[i];
        for (int64_t i = 0; i < b.cols; ++i) r[i] -= step * q[i];
      }
      EGOSIEVE_RETURN_IF_ERROR(precondition(residual.view, preconditioned.view));
      for (int64_t c = 0; c < b.rows; ++c) {
        if (products[c] == 0.0) continue;
        const double* z = preconditioned.view.row(c);
        const double product = Dot(residual.view.row(c), z, b.cols);
        double* p = direction.view.row(c);
        for (int64_t i = 0; i < b.cols; ++i) p[i] = z[i] + product / products[c] * p[i];
        products[c] = product;
      }
    }
    return absl::OkStatus();
  }
};

}  // namespace

absl::Status ConjugateGradientOptions::Validate() const {
  return kernels::CheckOptions({
      {"tolerance", tolerance, tolerance > 0.0 && tolerance < 1.0, "be above 0 and below 1"},
      {"iterations", iterations, iterations >= 1, "be positive"},
  });
}

absl::StatusOr<ConjugateGradientReport> SolveByConjugateGradients(
    LinearMap multiply, LinearMap precondition, const ConjugateGradientOptions& options,
    ConstMatrixView<double> b, MatrixView<double> x) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  Solver solver(multiply, precondition, options, b, x);
  double before = HUGE_VAL;
  for (bool first = true;; first = false) {
    EGOSIEVE_ASSIGN_OR_RETURN(const double residual, solver.TrueResidual());
    if (residual <= options.tolerance) return ConjugateGradientReport{solver.iterations, residual};
    const bool stands = !first && !(residual <= kLeastProgress * before);
    if (stands || !std::isfinite(residual) || solver.iterations >= options.iterations) {
      return NotPositiveDefinite(
          absl::StrFormat("conjugate gradients reached a relative residual of %.2g in %d "
                          "iterations, not %g; a larger "
                          "noise, a larger rank of the preconditioner or a larger tolerance helps",
                          residual, solver.iterations, options.tolerance));
    }
    before = residual;
    EGOSIEVE_RETURN_IF_ERROR(solver.Iterate());
  }
}

}  // namespace egosieve::gp
