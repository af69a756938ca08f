// Covariances in float32, which devices compute within dense posteriors alone.
#pragma once

#include <memory>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/ops/dense_posterior.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {

// k(x_i, z_j), row by row: the means k*.alpha with a weight of 1 for one input after another.
inline std::vector<float> Float32Covariances(const std::shared_ptr<Context>& context,
                                             const CovarianceParameters& parameters,
                                             ConstMatrixView<double> x, ConstMatrixView<double> z) {
  std::vector<float> k(x.rows * z.rows), mean(x.rows);
  std::vector<double> alpha(z.rows, 0.0);
  for (int64_t j = 0; j < z.rows; ++j) {
    alpha[j] = 1.0;
    const PosteriorModel model = {.covariance = parameters, .inputs = z, .alpha = alpha.data()};
    const auto posterior = Value(DensePosterior::Create(context, model));
    EXPECT_EQ(posterior->Evaluate(x, {mean.data()}).status(), absl::OkStatus());
    for (int64_t i = 0; i < x.rows; ++i) k[i * z.rows + j] = mean[i];
    alpha[j] = 0.0;
  }
  return k;
}

}  // namespace egosieve::kernels
