// Predictions from a posterior into the caller's arrays. Queries that are packed float32 are
// computed in one pass, others in pieces of 2^16 in float64. What needs float64 arithmetic, by the
// caller's wish or by gp/model/adaptive_posterior.h, is computed in a second pass. A query's result
// does not depend on other queries, so the pieces do not affect the results.
//
// Nothing is written until all results are computed, in memory of the call's own.
#ifndef EGOSIEVE_TOOLS_EMBED_C_PREDICTION_H_
#define EGOSIEVE_TOOLS_EMBED_C_PREDICTION_H_

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "gp/model/adaptive_posterior.h"
#include "kernels/runtime/context.h"
#include "tools/embed/include/egosieve/gaussian_process.h"

namespace egosieve::embed {

// A posterior with its device, or the first of its devices.
struct DevicePosterior {
  std::shared_ptr<kernels::Context> context;
  std::shared_ptr<const gp::AdaptivePosterior> posterior;
  absl::Status labels;  // if the targets are no labels: why there are no probabilities
  int64_t devices = 1;

  const gp::Posterior& in_float32() const { return posterior->in_float32(); }
  int64_t outputs() const { return in_float32().outputs(); }
  int64_t dimension() const { return in_float32().hyperparameters().covariance.input_dimension(); }
};

// Each does the work of the C function of that name; errors name its arguments.
absl::Status PredictPoints(const DevicePosterior& at, const egosieve_const_array* x,
                           egosieve_prediction* prediction);
absl::Status PredictGrid(const DevicePosterior& at, const egosieve_grid* grid,
                         egosieve_prediction* prediction);
absl::Status PredictImage(const DevicePosterior& at, const egosieve_image* image, int32_t stride,
                          egosieve_prediction* prediction);

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_PREDICTION_H_
