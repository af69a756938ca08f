#include "gp/training/sparse_likelihood.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

// Intermediate results for the value and the gradient.
struct Terms {
  SparseSolution solution;
  std::vector<double> beta;    // n
  std::vector<double> missed;  // k_ii - q_ii, n
  AlignedMatrix projections;   // v, n x m
  AlignedMatrix half;          // rows L_A^-1 v_i, n x m

  int64_t points() const { return static_cast<int64_t>(beta.size()); }
  int64_t inducing() const { return solution.inducing_size(); }
  ConstMatrixView<double> v() const { return projections.view(); }
};

absl::StatusOr<Terms> ComputeTerms(kernels::Context& context,
                                   const Hyperparameters& hyperparameters, const PointSet& points,
                                   ConstMatrixView<double> inducing,
                                   const SparseModelOptions& options) {
  Terms terms;
  EGOSIEVE_ASSIGN_OR_RETURN(terms.solution, SolveSparse(context, options, hyperparameters, points,
                                                        Widen(inducing), &terms.projections));
  const int64_t n = points.size(), m = inducing.rows;
  const SparseSolution& solution = terms.solution;
  terms.beta.resize(n);
  terms.half = AlignedMatrix(n, m);
  for (int64_t i = 0; i < n; ++i) {
    const double* v = terms.projections.row(i);
    const double* x = &points.inputs[i * inducing.cols];
    terms.beta[i] = (points.targets[i] - Dot(v, solution.weights.data(), m)) / solution.lambda[i];
    terms.missed.push_back(
        std::max(0.0, PriorVariance(hyperparameters.covariance, x) - Square(v, m)));
    std::copy_n(v, m, terms.half.row(i));
  }
  AppendRows(solution.sum_factor.view(), terms.half.view());
  return terms;
}

// (SL4).
struct PointDerivatives {
  std::vector<double> prior;  // r
  double noise = 0.0;         // sum of s
};

PointDerivatives DerivativesOf(const Terms& terms, SparseApproximation approximation) {
  PointDerivatives derivatives;
  const int64_t m = terms.inducing();
  for (int64_t i = 0; i < terms.points(); ++i) {
    const double lambda = terms.solution.lambda[i];
    const double* h = terms.half.row(i);
    const double g = terms.beta[i] * terms.beta[i] - (1.0 - Square(h, m) / lambda) / lambda;
    if (approximation == SparseApproximation::kFitc) {
      // If rounding made k_ii - q_ii negative, it is treated as the constant 0.
      derivatives.prior.push_back(terms.missed[i] > 0.0 ? 0.5 * g : 0.0);
      derivatives.noise += 0.5 * g;
    } else {
      derivatives.prior.push_back(-0.5 / lambda);
      derivatives.noise += 0.5 * (g + terms.missed[i] / (lambda * lambda));
    }
  }
  return derivatives;
}

// (SL5), m x n.
AlignedMatrix CrossWeights(const Terms& terms, const std::vector<double>& prior) {
  const int64_t n = terms.points(), m = terms.inducing();
  AlignedMatrix u(m, n);
  for (int64_t i = 0; i < n; ++i) {
    for (int64_t j = 0; j < m; ++j) u.row(j)[i] = terms.half.row(i)[j];
  }
  SolveLowerTransposed(terms.solution.sum_factor.view(), u.view());  // A^-1 V^T
  for (int64_t j = 0; j < m; ++j) {
    for (int64_t i = 0; i < n; ++i) {
      u.row(j)[i] = terms.solution.weights[j] * terms.beta[i] -
                    u.row(j)[i] / terms.solution.lambda[i] - 2.0 * prior[i] * terms.v()(i, j);
    }
  }
  SolveLowerTransposed(terms.solution.factor.view(), u.view());
  return u;
}

// (SL6), m x m, lower triangle.
AlignedMatrix InducingWeights(const Terms& terms, const std::vector<double>& prior) {
  const int64_t m = terms.inducing();
  AlignedMatrix b(m, m), inverse(m, m);
  InvertLower(terms.solution.sum_factor.view(), inverse.view());
  MultiplyInverse(inverse.view(), b.view());  // A^-1
  const std::vector<double>& a = terms.solution.weights;
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j <= i; ++j) {
      b.row(i)[j] = 0.5 * (a[i] * a[j] - (i == j ? 1.0 : 0.0) + b.row(i)[j]);
    }
  }
  std::vector<double> divisors(prior.size());  // 1 / e_i; infinite for e_i = 0
  for (size_t i = 0; i < prior.size(); ++i) divisors[i] = -1.0 / prior[i];
  AddTerms(terms.v(), divisors.data(), 1.0, b.view());
  MirrorLower(b.view());
  // L^-T B L^-1; B is symmetric.
  SolveLowerTransposed(terms.solution.factor.view(), b.view());
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j < i; ++j) std::swap(b.row(i)[j], b.row(j)[i]);
  }
  SolveLowerTransposed(terms.solution.factor.view(), b.view());
  for (int64_t i = 0; i < m; ++i) {
    for (int64_t j = 0; j < m; ++j) b.row(i)[j] = -b.row(i)[j];
  }
  return b;
}

}  // namespace

absl::StatusOr<MarginalLikelihood> ComputeSparseLikelihood(
    kernels::Context& context, const Hyperparameters& hyperparameters, const Observations& data,
    ConstMatrixView<double> inducing, LikelihoodOrder order, const SparseModelOptions& options) {
  EGOSIEVE_REQUIRE(InvalidArgument, inducing.rows >= 1, "no inducing inputs");
  PointSet points;
  points.Append(data, 0);
  EGOSIEVE_ASSIGN_OR_RETURN(const Terms terms,
                            ComputeTerms(context, hyperparameters, points, inducing, options));
  const SparseSolution& solution = terms.solution;
  const int64_t n = terms.points(), m = terms.inducing();
  double sum = static_cast<double>(n) * std::log(2.0 * M_PI);
  for (int64_t j = 0; j < m; ++j) sum += 2.0 * std::log(solution.sum_factor.row(j)[j]);
  for (int64_t i = 0; i < n; ++i) {
    sum += std::log(solution.lambda[i]) + points.targets[i] * terms.beta[i];  // (SL1)
    if (options.approximation == SparseApproximation::kDtc)
      sum += terms.missed[i] / solution.lambda[i];
  }
  MarginalLikelihood result;
  result.value = -0.5 * sum;
  if (order == LikelihoodOrder::kValue) return result;

  const PointDerivatives derivatives = DerivativesOf(terms, options.approximation);
  const AlignedMatrix u = CrossWeights(terms, derivatives.prior);
  const AlignedMatrix b = InducingWeights(terms, derivatives.prior);
  const kernels::CovarianceParameters& covariance = hyperparameters.covariance;
  EGOSIEVE_ASSIGN_OR_RETURN(
      result.gradient,
      kernels::CrossCovarianceGradient(context, covariance, inducing, data.inputs, u.view()));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> of_inducing,
                            kernels::CovarianceGradient(context, covariance, inducing, b.view()));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> of_prior,
                            kernels::VarianceGradient(covariance, data.inputs, derivatives.prior));
  for (size_t t = 0; t < result.gradient.size(); ++t) {
    result.gradient[t] += of_inducing[t] + of_prior[t];
  }
  double trace = 0.0;
  for (int64_t j = 0; j < m; ++j) trace += b.row(j)[j];
  const double noise = hyperparameters.noise_variance();
  const bool climbed = solution.jitter > options.relative_jitter * noise;
  result.gradient.push_back(2.0 * noise * derivatives.noise +
                            (climbed ? 0.0 : 2.0 * solution.jitter * trace));
  return result;
}

}  // namespace egosieve::gp
