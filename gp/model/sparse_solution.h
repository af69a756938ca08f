// The quantities that a sparse model computes from its points: projections on m inducing inputs u,
// and sums over them.
//
//   L L^T = K_uu + jitter I,  v_i = L^-1 k_u(x_i),  q_ii = |v_i|^2                           (SP1)
//   lambda_i = sigma_n^2 + nu_i                 DTC
//   lambda_i = sigma_n^2 + nu_i + k_ii - q_ii   FITC; nu_i: the point's own noise variance    (SP2)
//   A = I + sum_i v_i v_i^T / lambda_i,  c = sum_i v_i y_i / lambda_i                        (SP3)
//
// v is computed kRowTile points at a time and not kept: 8 m^2 bytes, of L, A and L_A each, and 16
// kRowTile m at work.
//
// If K_uu's factorisation refuses a pivot, the jitter increases by factors of ten to 1e-4
// sigma_f^2, from at least 1e-10 sigma_f^2 on.
//
// Reference: Quinonero-Candela & Rasmussen (2005), "A unifying view of sparse approximate Gaussian
// process regression".
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/model/point_set.h"
#include "gp/model/regression_weights.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

enum class SparseApproximation { kDtc, kFitc };

struct SparseModelOptions {
  SparseApproximation approximation = SparseApproximation::kDtc;
  int64_t inducing_points = 512;  // m, at most
  double refresh_share = 0.25;    // of the points added or removed before u is chosen anew
  double relative_jitter = 1e-6;  // of sigma_n^2, on K_uu's diagonal at first

  absl::Status Validate() const;
};

// The parts of a posterior without its squash: R of sparse_model.h, and the mean's weights L^-T A^-1
// c.
struct SparsePosteriorForm {
  AlignedMatrix root;
  RegressionWeights weights;
};

inline constexpr int64_t kRowTile = 2048;

// (SP3).
struct SparseSums {
  AlignedMatrix sum;               // A, m x m, lower triangle
  AlignedMatrix sum_factor;        // L_A, m x m
  std::vector<double> target_sum;  // c, m
  std::vector<double> weights;     // A^-1 c, m

  // Adds sign times the terms of v.rows points with these lambda and y to A and c. v: k x m.
  void Add(kernels::ConstMatrixView<double> v, const double* lambda, const double* targets,
           double sign);
  // L_A and A^-1 c from A and c. A's eigenvalues are at least 1. So this can only fail with NaN values
  // or with the rounding errors of removals.
  absl::Status Solve();
};

struct SparseSolution : SparseSums {
  std::vector<double> inducing_inputs;  // m x D
  double jitter = 0.0;                  // on K_uu's diagonal
  AlignedMatrix factor;                 // L, m x m
  std::vector<double> lambda;           // n
  // For the above; null before the first request.
  mutable std::shared_ptr<const SparsePosteriorForm> posterior_form;

  int64_t inducing_size() const { return factor.rows(); }
};

// FailedPrecondition if K_uu is not positive definite with the largest jitter. projections: where
// v, n x m, is written; null: it is not wanted.
absl::StatusOr<SparseSolution> SolveSparse(kernels::Context& context,
                                           const SparseModelOptions& options,
                                           const Hyperparameters& hyperparameters,
                                           const PointSet& points,
                                           std::vector<double> inducing_inputs,
                                           AlignedMatrix* projections = nullptr);
// The same with inducing inputs chosen among the points.
absl::StatusOr<SparseSolution> ChooseAndSolveSparse(kernels::Context& context,
                                                    const SparseModelOptions& options,
                                                    const Hyperparameters& hyperparameters,
                                                    const PointSet& points);

// (SP1), (SP2) for points with these noise variances (empty: all 0): rows of v (inputs.rows x m)
// and their lambdas; null: not wanted.
absl::Status ProjectPoints(kernels::Context& context, const SparseModelOptions& options,
                           const Hyperparameters& hyperparameters, const SparseSolution& solution,
                           kernels::ConstMatrixView<double> inputs,
                           absl::Span<const double> noise_variances, kernels::MatrixView<double> v,
                           double* lambda);

// A += sign sum_i v_i v_i^T / lambda_i, in the tiles of the lower triangle. v: k x m.
void AddTerms(kernels::ConstMatrixView<double> v, const double* lambda, double sign,
              kernels::MatrixView<double> a);
// c := A^-1 c.
void SolveSum(const AlignedMatrix& sum_factor, std::vector<double>& c);

}  // namespace egosieve::gp
