#include "gp/calibration/leave_one_out.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

constexpr double kLeastShare = 1e-10;  // smallest share of [K^-1]_ii that may remain with a mean
                                       // function

// Moves the first `count` rows of a seeded shuffle of `rows` to `out`.
void Draw(std::vector<int64_t>& rows, int64_t count, std::mt19937_64& generator,
          std::vector<int64_t>& out) {
  const int64_t size = static_cast<int64_t>(rows.size());
  for (int64_t i = 0; i < count; ++i) {
    std::swap(rows[i], rows[i + static_cast<int64_t>(generator() % (size - i))]);
    out.push_back(rows[i]);
  }
}

}  // namespace

std::vector<double> LeaveOneOut::LatentVariance(double noise_variance) const {
  std::vector<double> variance(target_variance.size());
  for (size_t i = 0; i < variance.size(); ++i) {
    const double own = noise_variances.empty() ? 0.0 : noise_variances[i];
    variance[i] = std::max(0.0, target_variance[i] - noise_variance - own);
  }
  return variance;
}

std::vector<double> LeaveOneOut::LogDensities(absl::Span<const double> targets) const {
  std::vector<double> densities(mean.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    for (int64_t c = 0; c < outputs; ++c) {
      const double error = targets[rows[i] * outputs + c] - mean[i * outputs + c];
      densities[i * outputs + c] =
          -0.5 * (std::log(2.0 * M_PI * target_variance[i]) + error * error / target_variance[i]);
    }
  }
  return densities;
}

absl::StatusOr<LeaveOneOut> ComputeLeaveOneOut(const IncrementalCholesky& factor,
                                               absl::Span<const double> targets,
                                               absl::Span<const double> alpha,
                                               absl::Span<const int64_t> rows,
                                               absl::Span<const double> mean_shares) {
  const size_t n = static_cast<size_t>(factor.size());
  const size_t outputs = n == 0 ? 1 : targets.size() / n;
  LeaveOneOut result;
  result.outputs = static_cast<int64_t>(outputs);
  result.rows.assign(rows.begin(), rows.end());
  if (rows.empty()) {
    result.rows.resize(n);
    std::iota(result.rows.begin(), result.rows.end(), int64_t{0});
  }
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<double> diagonal, factor.InverseDiagonal(result.rows));
  result.mean.resize(diagonal.size() * outputs);
  result.target_variance.resize(diagonal.size());
  for (size_t i = 0; i < diagonal.size(); ++i) {
    const int64_t row = result.rows[i];
    const double whole = diagonal[i];
    if (!mean_shares.empty()) diagonal[i] -= mean_shares[row];
    // A smaller rest of `whole` is rounding error.
    EGOSIEVE_REQUIRE(FailedPrecondition, diagonal[i] > kLeastShare * whole,
                     "without point %d the others do not determine the mean function", row);
    for (size_t c = 0; c < outputs; ++c) {
      const size_t place = row * outputs + c;
      result.mean[i * outputs + c] = targets[place] - alpha[place] / diagonal[i];
    }
    result.target_variance[i] = 1.0 / diagonal[i];
  }
  return result;
}

std::vector<int64_t> StratifiedSample(absl::Span<const double> targets, int64_t count,
                                      double minimum_class_share, uint64_t seed) {
  const int64_t n = static_cast<int64_t>(targets.size());
  std::vector<int64_t> sample;
  if (count >= n) {
    sample.resize(n);
    std::iota(sample.begin(), sample.end(), int64_t{0});
    return sample;
  }
  if (!(count > 0)) return sample;
  std::vector<int64_t> classes[2];
  for (int64_t i = 0; i < n; ++i) classes[targets[i] >= 0.0 ? 1 : 0].push_back(i);
  const int rare = classes[1].size() < classes[0].size() ? 1 : 0;
  const int64_t rare_size = static_cast<int64_t>(classes[rare].size());
  const double share = std::max(minimum_class_share, static_cast<double>(rare_size) / n);
  const int64_t rare_count =
      std::min<int64_t>(rare_size, std::llround(share * static_cast<double>(count)));
  std::mt19937_64 generator(seed);
  Draw(classes[rare], rare_count, generator, sample);
  Draw(classes[1 - rare], count - rare_count, generator, sample);
  std::sort(sample.begin(), sample.end());
  return sample;
}

}  // namespace egosieve::gp
