#include "gp/model/sample_paths.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "gp/model/point_set.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/prepared_points.h"
#include "kernels/base/splitmix.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kMostFrequencies = int64_t{1} << 20;
constexpr int64_t kRowsOfATask = 64;
constexpr double kFlopsOfAWave = 60.0;  // a sine and a cosine

uint64_t Derive(uint64_t key, uint64_t number) {
  return kernels::SplitMix(key + kernels::kSplitMixStep * (number + 1));
}

}  // namespace

absl::Status PathOptions::Validate() const {
  return kernels::CheckOptions({
      {"count", count, count >= 0, "not be negative"},
      {"frequencies", frequencies, frequencies >= 1 && frequencies <= kMostFrequencies,
       "be in [1, 2^20]"},
  });
}

absl::StatusOr<PriorPaths> PriorPaths::Draw(const Hyperparameters& hyperparameters,
                                            ConstMatrixView<double> points, int64_t outputs,
                                            const PathOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  const kernels::CovarianceParameters& covariance = hyperparameters.covariance;
  const kernels::CovarianceDescription& function = covariance.function.description();
  const int64_t dimension = covariance.input_dimension(), frequencies = options.frequencies;
  const double mass = function.SpectralMass(covariance.scales.data(), dimension);
  EGOSIEVE_REQUIRE(
      Unimplemented, mass > 0.0,
      "no frequencies are known of \"%s\"; sample paths are of squared_exponential, matern12, "
      "matern32, matern52, constant, and their sums and products; take joint samples",
      std::string(covariance.function.text()));
  PriorPaths paths;
  paths.frequencies_ = frequencies;
  paths.centre_ = kernels::CentreOf(points);
  for (int64_t c = 0; c < outputs; ++c) {
    for (int64_t s = 0; s < options.count; ++s) {
      paths.keys_.push_back(Derive(Derive(options.seed, 1), s * outputs + c));
    }
  }
  const int64_t width = dimension + 2;
  paths.waves_.resize(paths.columns() * frequencies * width);
  const double amplitude =
      covariance.signal_stddev * std::sqrt(mass / static_cast<double>(frequencies));
  kernels::ParallelFor(paths.columns(), kFlopsOfAWave * paths.columns() * frequencies * width,
                       [&](int64_t column) {
                         NormalStream normal(Derive(paths.keys_[column], 0));
                         for (int64_t j = 0; j < frequencies; ++j) {
                           double* wave = &paths.waves_[(column * frequencies + j) * width];
                           function.AddFrequency(
                               covariance.scales.data(), dimension, [&] { return normal(); }, wave);
                           wave[dimension] = amplitude * normal();
                           wave[dimension + 1] = amplitude * normal();
                         }
                       });
  return paths;
}

void PriorPaths::AddTo(ConstMatrixView<double> x, MatrixView<double> values) const {
  const int64_t dimension = x.cols, width = dimension + 2;
  const int64_t tasks = (x.rows + kRowsOfATask - 1) / kRowsOfATask;
  kernels::ParallelFor(tasks, kFlopsOfAWave * x.rows * columns() * frequencies_, [&](int64_t task) {
    std::vector<double> difference(dimension);
    for (int64_t i = task * kRowsOfATask; i < std::min(x.rows, (task + 1) * kRowsOfATask); ++i) {
      for (int64_t d = 0; d < dimension; ++d) difference[d] = x(i, d) - centre_[d];
      for (int64_t column = 0; column < columns(); ++column) {
        const double* wave = &waves_[column * frequencies_ * width];
        double sum = 0.0;
        for (int64_t j = 0; j < frequencies_; ++j, wave += width) {
          double phase = 0.0;
          for (int64_t d = 0; d < dimension; ++d) phase += wave[d] * difference[d];
          sum += wave[dimension] * std::cos(phase) + wave[dimension + 1] * std::sin(phase);
        }
        values(i, column) += sum;
      }
    }
  });
}

NormalStream PriorPaths::Numbers(int64_t column) const {
  return NormalStream(Derive(keys_[column], 1));
}

double PriorPaths::NoiseAt(int64_t column, const double* x, int64_t dimension) const {
  uint64_t key = Derive(keys_[column], 2);
  for (int64_t d = 0; d < dimension; ++d) {
    const double value = x[d] + 0.0;  // -0 is 0
    uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    key = Derive(key ^ bits, 0);
  }
  return NormalStream(key)();
}

SamplePaths::SamplePaths(std::shared_ptr<kernels::Context> context,
                         const Hyperparameters& hyperparameters, ConstMatrixView<double> points,
                         PriorPaths prior, const RegressionWeights& update, bool of_observation)
    : prior_(std::move(prior)),
      // Means alone: the factor only tells the number of points.
      update_(std::move(context), hyperparameters, points, update,
              {kernels::FactorKind::kNone, {nullptr, points.rows, points.rows}, nullptr}),
      noise_stddev_(of_observation ? hyperparameters.noise_stddev : 0.0) {}

absl::StatusOr<std::vector<double>> SamplePaths::Evaluate(ConstMatrixView<double> points) const {
  EGOSIEVE_RETURN_IF_ERROR(
      CheckPoints(points, update_.hyperparameters().covariance.input_dimension()));
  const int64_t columns = prior_.columns();
  std::vector<double> values(points.rows * columns);
  if (values.empty()) return values;
  EGOSIEVE_RETURN_IF_ERROR(update_.Evaluate(points, values.data(), nullptr).status());
  prior_.AddTo(points, {values.data(), points.rows, columns});
  if (noise_stddev_ == 0.0) return values;
  kernels::ParallelFor(points.rows, kFlopsOfAWave * points.rows * columns, [&](int64_t i) {
    for (int64_t c = 0; c < columns; ++c) {
      values[i * columns + c] += noise_stddev_ * prior_.NoiseAt(c, points.row(i), points.cols);
    }
  });
  return values;
}

}  // namespace egosieve::gp
