// Objectives for training the hyperparameters of a sparse model, with their gradients with respect
// to theta. There are n points and m inducing inputs.
//
//   Q = V V^T, V of (SP1), A and c of (SP3) in gp/model/sparse_solution.h
//
//   log N(y; 0, Q + Lambda) = -1/2 (sum_i log lambda_i + log|A| + y.beta + n log 2 pi)       (SL1)
//     beta = (Q + Lambda)^-1 y = Lambda^-1 (y - V a),  a = A^-1 c
//   VFE    (SL1) with lambda_i = sigma_n^2 + nu_i, less 1/2 sum_i (k_ii - q_ii) / lambda_i   (SL2)
//   FITC   (SL1) with lambda_i = sigma_n^2 + nu_i + k_ii - q_ii                              (SL3)
//
// (SL2) is a lower bound of the exact log marginal likelihood, and equal to it if the inducing
// inputs are the points. It rewards inducing inputs that explain the points, and does not treat
// their approximation error as noise, as (SL1) without the trace would. Predictions of a model
// trained by it are DTC's. (SL3) is not a bound, but the likelihood of its own model.
//
// With g_i = beta_i^2 - (1 / lambda_i - |L_A^-1 v_i|^2 / lambda_i^2), r_i the derivative by k_ii
// and e_i the derivative by q_ii, e_i = -r_i:
//
//   VFE    r_i = -1 / (2 lambda_i),  s_i = g_i / 2 + (k_ii - q_ii) / (2 lambda_i^2)          (SL4)
//   FITC   r_i = s_i = g_i / 2
//   d = sum_ij U_ij dk(u_i, x_j) + sum_ij B_ij dk(u_i, u_j)
//       + sum_i r_i dk_ii + sum_i s_i dsigma_n^2
//   U = L^-T (a beta^T - A^-1 V^T Lambda^-1 + 2 V^T diag(e))                                 (SL5)
//   B = -L^-T (1/2 (a a^T - I + A^-1) + V^T diag(e) V) L^-1                                  (SL6)
//
// The inducing inputs are held fixed. The jitter on K_uu is a fixed share of sigma_n^2 and part of
// the derivative by log sigma_n. Cost: 2 n m^2 flops and n m + m^2 / 2 derivatives of covariances.
//
// References: Titsias (2009), "Variational learning of inducing variables in sparse Gaussian
// processes", eq. 9; Snelson & Ghahramani (2006); Bauer, van der Wilk & Rasmussen (2016).
#pragma once

#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/point_set.h"
#include "gp/model/sparse_solution.h"
#include "gp/training/marginal_likelihood.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

// inducing: m x D; InvalidArgument for m = 0. options: FITC's objective for FITC, else VFE, and the
// jitter on K_uu. Hyperparameters with the zero mean, and observations of one output, both valid.
// FailedPrecondition if K_uu is not positive definite with the largest jitter.
absl::StatusOr<MarginalLikelihood> ComputeSparseLikelihood(
    kernels::Context& context, const Hyperparameters& hyperparameters, const Observations& data,
    kernels::ConstMatrixView<double> inducing, LikelihoodOrder order,
    const SparseModelOptions& options = {});

}  // namespace egosieve::gp
