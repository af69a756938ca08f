#include "gp/model/adaptive_posterior.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/container/fixed_array.h"
#include "gp/covariance/hyperparameters.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;

constexpr int64_t kInputs = 8;           // half of S
constexpr double kSafety = 4.0;          // of (AP3), (AP4)
constexpr double kVarianceShare = 0.02;  // of (AP6)

// Whether k(x, x) stays within a few times `largest` far from the inputs.
bool IsPriorBounded(const kernels::CovarianceParameters& covariance, ConstMatrixView<double> inputs,
                    double largest) {
  constexpr double kFar = 1e3;
  for (const double sign : {-1.0, 1.0}) {
    std::vector<double> far(inputs.cols);
    for (int64_t d = 0; d < inputs.cols; ++d) {
      double size = 1.0;
      for (int64_t i = 0; i < inputs.rows; ++i) size = std::max(size, std::abs(inputs(i, d)));
      far[d] = sign * kFar * size;
    }
    if (!(PriorVariance(covariance, far.data()) <= 4.0 * largest)) return false;
  }
  return true;
}

}  // namespace

absl::StatusOr<AdaptivePosterior::Places> AdaptivePosterior::MakePlaces() const {
  const ConstMatrixView<double> inputs = in_float64_->inputs();
  const kernels::CovarianceParameters& covariance = in_float64_->hyperparameters().covariance;
  const int64_t count = std::min(kInputs, inputs.rows), dimension = inputs.cols;
  Places places;
  for (int64_t s = 0; s < count; ++s) {
    const int64_t row = s * inputs.rows / count;
    const double* x = inputs.row(row);
    const double* next = inputs.row((row + 1) % inputs.rows);
    places.points.insert(places.points.end(), x, x + dimension);
    const double step = s % 2 == 0 ? 0.5 : -0.5;
    for (int64_t d = 0; d < dimension; ++d) places.points.push_back(x[d] + step * (next[d] - x[d]));
  }
  const ConstMatrixView<double> points(places.points.data(), 2 * count, dimension);
  places.means.resize(points.rows * in_float64_->outputs());
  places.variances.resize(points.rows);
  if (points.rows == 0) return places;
  EGOSIEVE_RETURN_IF_ERROR(
      in_float64_->Evaluate(points, places.means.data(), places.variances.data()).status());
  double prior = 0.0;
  for (int64_t s = 0; s < points.rows; ++s) {
    prior = std::max(prior, PriorVariance(covariance, points.row(s)));
  }
  places.error.prior = IsPriorBounded(covariance, inputs, prior) ? 0.0 : prior;
  places.error.deviation =
      std::sqrt(*std::min_element(places.variances.begin(), places.variances.end()));
  return places;
}

absl::StatusOr<Float32Error> AdaptivePosterior::Error(bool with_variance) const {
  if (!in_float64_->has_factor()) return Float32Error{HUGE_VAL, HUGE_VAL};
  const std::lock_guard lock(mutex_);
  if (measured_.has_value() && (measured_->has_variance_error || !with_variance)) {
    return measured_->error;
  }
  Places places;
  if (measured_.has_value()) {
    places = *measured_;
  } else {
    EGOSIEVE_ASSIGN_OR_RETURN(places, MakePlaces());
  }
  std::vector<float> means(places.means.size()), variances(places.variances.size());
  kernels::PosteriorCounts counts;
  if (!variances.empty()) {
    const int64_t count = static_cast<int64_t>(variances.size());
    const ConstMatrixView<double> points(places.points.data(), count, in_float64_->inputs().cols);
    EGOSIEVE_ASSIGN_OR_RETURN(
        counts, in_float32_->Evaluate(
                    points, {means.data(), with_variance ? variances.data() : nullptr, nullptr}));
  }
  const auto bound = [](const std::vector<float>& narrow, const std::vector<double>& wide) {
    double sum = 0.0;
    for (size_t i = 0; i < narrow.size(); ++i) sum += (narrow[i] - wide[i]) * (narrow[i] - wide[i]);
    if (!std::isfinite(sum)) return HUGE_VAL;
    return kSafety * std::sqrt(sum / std::max<double>(1.0, static_cast<double>(narrow.size())));
  };
  places.error.mean = bound(means, places.means);
  if (with_variance) places.error.variance = bound(variances, places.variances);
  if (counts.clamped_variances > 0) places.error.variance = HUGE_VAL;
  places.has_variance_error = with_variance;
  measured_ = std::move(places);
  return measured_->error;
}

template <typename Query>
void AdaptivePosterior::FindInsufficient(const Float32Error& error, ConstMatrixView<Query> queries,
                                         const float* variances, int64_t first,
                                         std::vector<int64_t>& rows) const {
  if (error.variance == 0.0) return;
  // The least variances that suffice for the factors 1 and s(x) / min_s s(x_s) of (AP4).
  const double unit = error.variance / kVarianceShare;
  const double root = unit / error.deviation;
  const double least = std::max(unit, root * root);
  if (error.prior == 0.0) {
    for (int64_t i = 0; i < queries.rows; ++i) {
      if (!(variances[i] >= least)) rows.push_back(first + i);
    }
    return;
  }
  const kernels::CovarianceParameters& covariance = in_float64_->hyperparameters().covariance;
  std::vector<double> factors(queries.rows);
  kernels::ParallelFor(queries.rows, 50.0 * queries.rows * queries.cols, [&](int64_t i) {
    absl::FixedArray<double, 64> x(queries.cols);
    std::copy_n(queries.row(i), queries.cols, x.begin());
    factors[i] = PriorVariance(covariance, x.data()) / error.prior;
  });
  for (int64_t i = 0; i < queries.rows; ++i) {
    if (!(variances[i] >= std::max(least, unit * factors[i]))) rows.push_back(first + i);
  }
}

template void AdaptivePosterior::FindInsufficient(const Float32Error&, ConstMatrixView<float>,
                                                  const float*, int64_t,
                                                  std::vector<int64_t>&) const;
template void AdaptivePosterior::FindInsufficient(const Float32Error&, ConstMatrixView<double>,
                                                  const float*, int64_t,
                                                  std::vector<int64_t>&) const;

}  // namespace egosieve::gp
