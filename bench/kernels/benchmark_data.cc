#include "bench/kernels/benchmark_data.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>
#include <utility>

#include "kernels/ops/covariance_matrix.h"
#include "vision/image/image_grid.h"

namespace egosieve::kernels {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

// Waves of brightness and colour with a little noise.
void ImageInputs(double x, double y, std::mt19937_64& random, double* out) {
  const vision::PixelNormalization map = vision::NormalizationForImage(kWidth, kHeight);
  out[0] = x * map.scale + map.u_offset;
  out[1] = y * map.scale + map.v_offset;
  const auto noise = [&] {
    return 0.05 * (std::ldexp(static_cast<double>(random() >> 11), -52) - 1.0);
  };
  out[3] = 0.6 * std::sin(0.03 * x) * std::cos(0.02 * y) + noise();
  out[4] = 0.6 * std::sin(0.02 * x + 1.0) + noise();
  out[5] = 0.6 * std::cos(0.025 * (x - y)) + noise();
  out[2] = 0.299 * out[3] + 0.587 * out[4] + 0.114 * out[5];
}

}  // namespace

std::shared_ptr<Context> BenchmarkContext() {
  static const absl::StatusOr<std::shared_ptr<Context>> context = OpenContext();
  if (!context.ok()) {
    std::fprintf(stderr, "%s\n", context.status().ToString().c_str());
    std::exit(3);
  }
  return *context;
}

CovarianceParameters BenchmarkCovariance(BenchmarkKernel kernel) {
  const std::vector<double> gentle = {0.4, 0.4, 0.4, 0.4, 0.3, 0.3, 0.3};
  const std::vector<double> steep = {2.0, 15.0, 12.0, 2.0, 1.5, 1.5, 1.5};
  const std::vector<double> lengths = {0.3, 0.3, 0.6, 0.6, 0.6, 0.6};
  if (kernel == BenchmarkKernel::kSquaredExponential) {
    return {CovarianceFunction::kSquaredExponential, lengths, 1.0};
  }
  if (kernel == BenchmarkKernel::kMatern52) {
    return {CovarianceFunction::Parse("matern52").value(), lengths, 1.0};
  }
  return {CovarianceFunction::kArcsine, kernel == BenchmarkKernel::kGentleArcsine ? gentle : steep,
          1.0};
}

PosteriorModel BenchmarkModel::model(FactorKind kind) const {
  PosteriorModel model;
  model.covariance = covariance;
  model.inputs = ConstMatrixView<double>(inputs.data(), count, 6);
  model.alpha = alpha.data();
  model.factor_kind = kind;
  const std::vector<double>& factor = kind == FactorKind::kInverseCholesky ? inverse : cholesky;
  model.factor = ConstMatrixView<double>(factor.data(), count, count);
  model.squash_a = 2.0;
  model.squash_b = -0.1;
  return model;
}

const BenchmarkModel& ModelOf(int64_t n, BenchmarkKernel kernel) {
  static std::map<std::pair<int64_t, BenchmarkKernel>, BenchmarkModel> models;
  BenchmarkModel& model = models[{n, kernel}];
  if (model.count == n) return model;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::mt19937_64 random(n);
  model.covariance = BenchmarkCovariance(kernel);
  model.count = n;
  model.inputs.resize(n * 6);
  Eigen::VectorXd y(n);
  for (int64_t i = 0; i < n; ++i) {
    const double px = static_cast<double>(random() % kWidth);
    const double py = static_cast<double>(random() % kHeight);
    ImageInputs(px, py, random, &model.inputs[i * 6]);
    y[i] = std::hypot(px - 400, py - 300) < 80 ? 1.0 : -1.0;
  }
  model.cholesky.assign(n * n, 0.0);
  const absl::Status status =
      CovarianceMatrix(*BenchmarkContext(), model.covariance, {model.inputs.data(), n, 6}, 0.09,
                       Triangle::kFull, MatrixView<double>(model.cholesky.data(), n, n));
  if (!status.ok()) {
    std::fprintf(stderr, "%s\n", status.ToString().c_str());
    std::exit(3);
  }
  Eigen::Map<RowMajor> factor(model.cholesky.data(), n, n);
  const RowMajor lower = factor.llt().matrixL();
  factor = lower;
  const Eigen::VectorXd alpha = lower.transpose().triangularView<Eigen::Upper>().solve(
      lower.triangularView<Eigen::Lower>().solve(y));
  model.alpha.assign(alpha.data(), alpha.data() + n);
  if (n <= 1000) {
    const RowMajor inverse = lower.triangularView<Eigen::Lower>().solve(RowMajor::Identity(n, n));
    model.inverse.assign(inverse.data(), inverse.data() + n * n);
  }
  return model;
}

std::vector<float> ImageQueries(int stride) {
  const vision::ImageGrid grid = {kWidth, kHeight, stride};
  std::mt19937_64 random(stride);
  std::vector<float> queries;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      double inputs[6];
      ImageInputs(grid.x_pixels(column), grid.y_pixels(row), random, inputs);
      queries.insert(queries.end(), inputs, inputs + 6);
    }
  }
  return queries;
}

}  // namespace egosieve::kernels
