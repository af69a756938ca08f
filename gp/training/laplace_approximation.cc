#include "gp/training/laplace_approximation.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/not_positive_definite.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int kMostSteps = 100;
constexpr double kTolerance = 1e-12;  // of the objective's rise, relative to 1 + |objective|
constexpr double kLeastBend = 1e-12;  // of W in the equivalent regression
constexpr double kLargestWeight = 1e6;

// log p(t | f) and its derivatives; `bend` is W, `ratio` W' / W.
struct Likelihood {
  double value = 0.0;
  std::vector<double> slope, bend, ratio, targets;
};

std::vector<double> Multiply(ConstMatrixView<double> k, const std::vector<double>& x) {
  std::vector<double> product(k.rows);
  kernels::ParallelFor(k.rows, 2.0 * k.rows * k.cols,
                       [&](int64_t i) { product[i] = Dot(k.row(i), x.data(), k.cols); });
  return product;
}

class LaplaceProblem {
 public:
  LaplaceProblem(const LabelledInputs& data, ConstMatrixView<double> k)
      : data_(data), k_(k), n_(k.rows), f_(n_, 0.0), a_(n_, 0.0), l_(n_, n_) {}

  // (LA1); afterwards f_, at_ and l_ are those of f^.
  absl::Status FindMode() {
    at_ = Evaluate(f_);
    double objective = at_.value;
    bool converged = false;
    for (int step = 0;; ++step) {
      EGOSIEVE_RETURN_IF_ERROR(Factorize());
      if (converged || step == kMostSteps) return absl::OkStatus();
      std::vector<double> b(n_), a(n_);
      for (int64_t i = 0; i < n_; ++i) b[i] = at_.bend[i] * f_[i] + at_.slope[i];
      const std::vector<double> r = MultiplyByR(Multiply(k_, b));
      for (int64_t i = 0; i < n_; ++i) a[i] = b[i] - r[i];
      std::vector<double> f = Multiply(k_, a);
      const double room = kTolerance * (1.0 + std::abs(objective));
      double next = 0.0;
      for (int halving = 0; halving < 40; ++halving) {
        at_ = Evaluate(f);
        next = at_.value - 0.5 * Dot(a.data(), f.data(), n_);
        if (next >= objective - room) break;
        for (int64_t i = 0; i < n_; ++i) {
          a[i] = 0.5 * (a[i] + a_[i]);
          f[i] = 0.5 * (f[i] + f_[i]);
        }
      }
      converged = !(next - objective > room);
      a_ = std::move(a);
      f_ = std::move(f);
      objective = next;
    }
  }

  // (LA2), with f^ = K a.
  double LogLikelihood() const {
    double value = at_.value - 0.5 * Dot(a_.data(), f_.data(), n_);
    for (int64_t i = 0; i < n_; ++i) value -= std::log(l_.row(i)[i]);
    return value;
  }

  // The lower triangle of the matrix before dK in (LA3). Overwrites l_.
  ConstMatrixView<double> GradientWeights() {
    {
      AlignedMatrix inverse(n_, n_);
      InvertLower(l_.view(), inverse.view());
      MultiplyInverse(inverse.view(), l_.view());
    }
    MirrorLower(l_.view());
    std::vector<double> s(n_), root(n_);
    for (int64_t i = 0; i < n_; ++i) {
      s[i] = -0.5 * at_.ratio[i] * (1.0 - l_.row(i)[i]);
      root[i] = std::sqrt(at_.bend[i]);
    }
    for (int64_t i = 0; i < n_; ++i) {
      for (int64_t j = 0; j < n_; ++j) l_.row(i)[j] *= root[i] * root[j];
    }
    const std::vector<double> r = Multiply(l_.view(), Multiply(k_, s));
    const std::vector<double>& g = at_.slope;
    for (int64_t i = 0; i < n_; ++i) {
      for (int64_t j = 0; j <= i; ++j) {
        l_.row(i)[j] = g[i] * g[j] - l_.row(i)[j] + (s[i] - r[i]) * g[j] + g[i] * (s[j] - r[j]);
      }
    }
    return l_.view();
  }

  void MakeRegression(LaplaceApproximation& result) const {
    result.targets = at_.targets;
    for (const double bend : at_.bend) {
      result.noise_variances.push_back(1.0 / std::max(bend, kLeastBend));
    }
  }

 private:
  Likelihood Evaluate(const std::vector<double>& f) const {
    Likelihood at;
    for (int64_t i = 0; i < n_; ++i) {
      const double t = data_.labels[i], z = t * f[i];
      const double weight = data_.weights.empty() ? 1.0 : data_.weights[i];
      const LogDistribution phi = LogNormalDistribution(z);
      const double sum = phi.derivative + z;
      at.value += weight * phi.value;
      at.slope.push_back(weight * t * phi.derivative);
      at.bend.push_back(weight * phi.derivative * sum);
      at.ratio.push_back(t * (1.0 / sum - phi.derivative - sum));
      at.targets.push_back(f[i] + t / sum);
    }
    return at;
  }

  absl::Status Factorize() {
    std::vector<double> root(n_);
    for (int64_t i = 0; i < n_; ++i) root[i] = std::sqrt(at_.bend[i]);
    for (int64_t i = 0; i < n_; ++i) {
      for (int64_t j = 0; j <= i; ++j) l_.row(i)[j] = root[i] * k_(i, j) * root[j];
      l_.row(i)[i] += 1.0;
    }
    const int64_t bad = FactorizeInParallel(l_.view(), PivotFloors(l_.view(), n_, 1.0));
    if (bad < 0) return absl::OkStatus();
    return NotPositiveDefinite(absl::StrFormat(
        "row %d: the covariances are not positive definite to working precision", bad));
  }

  // R x.
  std::vector<double> MultiplyByR(std::vector<double> x) const {
    for (int64_t i = 0; i < n_; ++i) x[i] *= std::sqrt(at_.bend[i]);
    const MatrixView<double> column(x.data(), n_, 1);
    SolveLower(l_.view(), column);
    SolveLowerTransposed(l_.view(), column);
    for (int64_t i = 0; i < n_; ++i) x[i] *= std::sqrt(at_.bend[i]);
    return x;
  }

  const LabelledInputs& data_;
  const ConstMatrixView<double> k_;
  const int64_t n_;
  std::vector<double> f_, a_;  // f = K a
  Likelihood at_;              // at f
  AlignedMatrix l_;
};

absl::Status CheckLabelled(const LabelledInputs& data) {
  const size_t n = static_cast<size_t>(data.inputs.rows);
  EGOSIEVE_REQUIRE(InvalidArgument,
                   data.labels.size() == n && (data.weights.empty() || data.weights.size() == n),
                   "%d labels and %d weights for %d points", data.labels.size(),
                   data.weights.size(), n);
  for (size_t i = 0; i < n; ++i) {
    EGOSIEVE_REQUIRE(InvalidArgument, data.labels[i] == 1.0 || data.labels[i] == -1.0,
                     "label %d is %g; it must be -1 or 1", i, data.labels[i]);
    EGOSIEVE_REQUIRE(
        InvalidArgument,
        data.weights.empty() || (data.weights[i] > 0.0 && data.weights[i] <= kLargestWeight),
        "weight %d is %g; it must be positive and at most 1e6", i, data.weights[i]);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<LaplaceApproximation> ApproximateByLaplace(
    kernels::Context& context, const kernels::CovarianceParameters& covariance,
    const LabelledInputs& data, LikelihoodOrder order) {
  EGOSIEVE_RETURN_IF_ERROR(CheckLabelled(data));
  const int64_t n = data.inputs.rows;
  AlignedMatrix k(n, n);
  EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix(context, covariance, data.inputs, 0.0,
                                                     kernels::Triangle::kFull, k.view()));
  LaplaceProblem problem(data, k.view());
  EGOSIEVE_RETURN_IF_ERROR(problem.FindMode());
  LaplaceApproximation result;
  result.log_likelihood = problem.LogLikelihood();
  problem.MakeRegression(result);
  if (order == LikelihoodOrder::kValue) return result;
  EGOSIEVE_ASSIGN_OR_RETURN(
      result.gradient,
      kernels::CovarianceGradient(context, covariance, data.inputs, problem.GradientWeights()));
  for (double& component : result.gradient) component *= 0.5;
  return result;
}

}  // namespace egosieve::gp
