#include "gp/model/regression_weights.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/container/fixed_array.h"
#include "gp/linalg/cholesky.h"
#include "kernels/base/argument_checks.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

// B := (L L^T)^-1 B.
void SolveBoth(ConstMatrixView<double> factor, MatrixView<double> b) {
  SolveLower(factor, b);
  SolveLowerTransposed(factor, b);
}

// out := a^T b; the rows of a and b are points.
void TransposedProduct(const std::vector<double>& a, int64_t columns, ConstMatrixView<double> b,
                       std::vector<double>& out) {
  std::fill(out.begin(), out.end(), 0.0);
  for (int64_t i = 0; i < b.rows; ++i) {
    for (int64_t p = 0; p < columns; ++p) {
      for (int64_t c = 0; c < b.cols; ++c) out[p * b.cols + c] += a[i * columns + p] * b(i, c);
    }
  }
}

}  // namespace

absl::Status RegressionWeights::CheckDetermined() const {
  EGOSIEVE_REQUIRE(FailedPrecondition, determined,
                   "%d points do not determine the %d coefficients of the mean function; add "
                   "points that differ in every input",
                   points, basis);
  return absl::OkStatus();
}

template <typename Input>
void RegressionWeights::AddMeanFunction(int64_t dimension, const Input* x, double* means) const {
  if (basis == 0) return;
  absl::FixedArray<double, 64> h(basis);
  EvaluateBasis(mean, dimension, x, h.data());
  for (int64_t p = 0; p < basis; ++p) {
    for (int64_t c = 0; c < outputs; ++c) means[c] += coefficients[p * outputs + c] * h[p];
  }
}

double RegressionWeights::ReducedBasis(int64_t dimension, const double* x, const double* sums,
                                       double* r) const {
  if (basis == 0) return 0.0;
  EvaluateBasis(mean, dimension, x, r);
  for (int64_t p = 0; p < basis; ++p) r[p] -= sums[p];
  return SolveInformation(r);
}

double RegressionWeights::SolveInformation(double* r) const {
  double square = 0.0;
  for (int64_t p = 0; p < basis; ++p) {
    for (int64_t o = 0; o < p; ++o) r[p] -= information[p * basis + o] * r[o];
    r[p] /= information[p * basis + p];
    square += r[p] * r[p];
  }
  return square;
}

std::vector<double> RegressionWeights::ReducedRows() const {
  std::vector<double> rows(basis_weights);
  for (int64_t i = 0; basis > 0 && i < points; ++i) SolveInformation(&rows[i * basis]);
  return rows;
}

template void RegressionWeights::AddMeanFunction(int64_t, const float*, double*) const;
template void RegressionWeights::AddMeanFunction(int64_t, const double*, double*) const;

double RegressionWeights::HalfLogDeterminant() const {
  double sum = 0.0;
  for (int64_t p = 0; p < basis; ++p) sum += std::log(information[p * basis + p]);
  return sum;
}

WeightsMemory::WeightsMemory(MeanFunction mean, int64_t dimension, int64_t points,
                             int64_t outputs) {
  const int64_t q = CoefficientCount(mean, dimension);
  weights.mean = mean;
  weights.points = points;
  weights.outputs = outputs;
  weights.basis = q;
  weights.alpha.resize(points * outputs);
  weights.coefficients.resize(q * outputs);
  weights.basis_weights.resize(points * q);
  weights.information.resize(q * q);
  basis.resize(points * q);
  floors.resize(q);
}

RegressionWeights SolveWeights(ConstMatrixView<double> factor, MeanFunction mean,
                               ConstMatrixView<double> inputs, ConstMatrixView<double> targets) {
  return SolveWeights(factor, inputs, targets,
                      WeightsMemory(mean, inputs.cols, targets.rows, targets.cols));
}

RegressionWeights SolveWeights(ConstMatrixView<double> factor, ConstMatrixView<double> inputs,
                               ConstMatrixView<double> targets, WeightsMemory memory) {
  RegressionWeights& weights = memory.weights;
  const int64_t n = weights.points, k = weights.outputs, q = weights.basis;
  for (int64_t i = 0; i < n; ++i) {
    std::copy_n(targets.row(i), k, weights.alpha.begin() + i * k);
  }
  if (q > 0) {
    std::vector<double>& basis = memory.basis;
    for (int64_t i = 0; i < n; ++i) {
      EvaluateBasis(weights.mean, inputs.cols, inputs.row(i), &basis[i * q]);
    }
    std::copy(basis.begin(), basis.end(), weights.basis_weights.begin());
    SolveBoth(factor, {weights.basis_weights.data(), n, q});
    TransposedProduct(weights.basis_weights, q, {basis.data(), n, q},
                      weights.information);  // (W1)
    const MatrixView<double> m(weights.information.data(), q, q);
    // Dependent columns of K_y^-1 H leave a pivot of the size of rounding, n eps.
    PivotFloors(m, n, 10.0, absl::MakeSpan(memory.floors));
    weights.determined = FactorizeInParallel(m, memory.floors) < 0;
    if (!weights.determined) {
      weights.alpha.clear();
      weights.coefficients.clear();
      return std::move(weights);
    }
    TransposedProduct(weights.basis_weights, q, targets, weights.coefficients);
    SolveBoth(m, {weights.coefficients.data(), q, k});
    for (int64_t i = 0; i < n; ++i) {
      for (int64_t c = 0; c < k; ++c) {
        for (int64_t p = 0; p < q; ++p) {
          weights.alpha[i * k + c] -= basis[i * q + p] * weights.coefficients[p * k + c];
        }
      }
    }
  }
  SolveBoth(factor, {weights.alpha.data(), n, k});  // (W2)
  return std::move(weights);
}

void WeightedSums(const double* k, const std::vector<double>& weights, int64_t points,
                  int64_t columns, double* out) {
  std::fill_n(out, columns, 0.0);
  const double* row = weights.data();
  for (int64_t j = 0; j < points; ++j, row += columns) {
    for (int64_t c = 0; c < columns; ++c) out[c] += k[j] * row[c];
  }
}

}  // namespace egosieve::gp
