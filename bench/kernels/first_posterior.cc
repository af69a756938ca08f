// Makes a first posterior: opens the default device, creates a small model, evaluates one query
// with mean, variance and probability, and prints the mean. BM_ColdStart times this program.
#include <cstdio>

#include "kernels/ops/dense_posterior.h"

int main() {
  using namespace egosieve::kernels;
  const auto context = OpenContext();
  if (!context.ok()) {
    std::fprintf(stderr, "%s\n", context.status().ToString().c_str());
    return 3;
  }
  const double inputs[] = {-0.5, 0.25, 0.5, -0.25};
  const double alpha[] = {1.0, -1.0};
  const double factor[] = {1.0, 0.0, 0.5, 1.0};
  PosteriorModel model;
  model.covariance = {CovarianceFunction::kArcsine, {1.0, 1.0, 1.0}, 1.0};
  model.inputs = ConstMatrixView<double>(inputs, 2, 2);
  model.alpha = alpha;
  model.factor_kind = FactorKind::kCholesky;
  model.factor = ConstMatrixView<double>(factor, 2, 2);
  const auto posterior = DensePosterior::Create(*context, model);
  const float query[] = {0.125f, 0.5f};
  float mean = 0.0f, variance = 0.0f, probability = 0.0f;
  if (!posterior.ok() ||
      !(*posterior)
           ->Evaluate(ConstMatrixView<float>(query, 1, 2), {&mean, &variance, &probability})
           .ok()) {
    return 4;
  }
  std::printf("%.6f\n", mean);
  return 0;
}
