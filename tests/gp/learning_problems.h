// Seeded learning problems, the default device, and GPML's demonstration data.
#ifndef EGOSIEVE_TESTS_GP_LEARNING_PROBLEMS_H_
#define EGOSIEVE_TESTS_GP_LEARNING_PROBLEMS_H_

#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "gp/covariance/hyperparameters.h"
#include "gtest/gtest.h"
#include "kernels/runtime/context.h"
#include "tests/gp/linalg/random_matrices.h"
#include "tests/kernels/gpml_demo.h"

namespace egosieve::gp {

inline std::shared_ptr<kernels::Context> TestContext() {
  static const auto context = kernels::OpenContext();
  EXPECT_TRUE(context.ok()) << context.status();
  return context.ok() ? *context : nullptr;
}

struct LabelledPoints {
  RowMatrix inputs;
  std::vector<double> labels;  // in [0, 1]
  std::vector<double> targets() const {
    std::vector<double> y(labels);
    for (double& value : y) value = 2.0 * value - 1.0;
    return y;
  }
};

// Points in [-1, 1]^D; those with x_0 + x_1^2 > 1/2 (about one in four) are labelled high, with a
// tenth of the labels the wrong way round, all of them soft.
inline LabelledPoints NoisyBlobs(int64_t n, int64_t dimension, std::mt19937_64& generator) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  LabelledPoints points;
  points.inputs = RandomPoints(n, dimension, generator);
  for (int64_t i = 0; i < n; ++i) {
    const double u = points.inputs(i, 0);
    const double v = dimension > 1 ? points.inputs(i, 1) : 0.0;
    const bool high = (u + v * v > 0.5) != (uniform(generator) < 0.1);
    points.labels.push_back(high ? 0.7 + 0.3 * uniform(generator) : 0.3 * uniform(generator));
  }
  return points;
}

// Hyperparameters with no two scales alike.
inline Hyperparameters UnevenHyperparameters(kernels::CovarianceFunction function,
                                             int64_t dimension) {
  Hyperparameters hyperparameters = DefaultHyperparameters(function, dimension);
  double factor = 0.7;
  for (double& scale : hyperparameters.covariance.scales) scale *= factor *= 1.1;
  hyperparameters.covariance.signal_stddev = 1.3;
  hyperparameters.noise_stddev = 0.3;
  return hyperparameters;
}

struct RegressionData {
  RowMatrix inputs;
  std::vector<double> targets;
};

// The 20 points of GPML's regression demonstration.
inline RegressionData GpmlDemo() {
  RegressionData data;
  data.inputs.resize(std::size(kernels::kGpmlDemo), 1);
  for (const auto& [x, y] : kernels::kGpmlDemo) {
    data.inputs(static_cast<int64_t>(data.targets.size()), 0) = x;
    data.targets.push_back(y);
  }
  return data;
}

// covNNone with (log ell, log sf) and log sigma_n: 2 Sigma = I / ell^2.
inline Hyperparameters GpmlNeuralNetwork(double log_ell, double log_sf, double log_noise) {
  Hyperparameters hyperparameters;
  hyperparameters.covariance.function = kernels::CovarianceFunction::kArcsine;
  hyperparameters.covariance.scales.assign(2, std::exp(-log_ell) * M_SQRT1_2);
  hyperparameters.covariance.signal_stddev = std::exp(log_sf);
  hyperparameters.noise_stddev = std::exp(log_noise);
  return hyperparameters;
}

}  // namespace egosieve::gp

#endif  // EGOSIEVE_TESTS_GP_LEARNING_PROBLEMS_H_
