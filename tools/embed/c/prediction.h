// Predictions from a posterior into the caller's arrays, in one pass where the queries lie packed
// in float32, else through pieces of 2^16: a query's result depends on no other query, so pieces do
// not show in the results.
//
// Nothing is written before all results are there, in memory of the call's own.
#ifndef EGOSIEVE_TOOLS_EMBED_C_PREDICTION_H_
#define EGOSIEVE_TOOLS_EMBED_C_PREDICTION_H_

#include <memory>

#include "absl/status/status.h"
#include "gp/model/posterior.h"
#include "kernels/runtime/context.h"
#include "tools/embed/include/egosieve/gaussian_process.h"

namespace egosieve::embed {

// A posterior with the device that it lies on.
struct DevicePosterior {
  std::shared_ptr<kernels::Context> context;
  std::shared_ptr<const gp::Posterior> posterior;
  absl::Status labels;  // why there are no probabilities, where its targets are no labels

  int64_t outputs() const { return posterior->outputs(); }
  int64_t dimension() const { return posterior->hyperparameters().covariance.input_dimension(); }
};

// As the functions of the C interface with these names; errors name their arguments.
absl::Status PredictPoints(const DevicePosterior& at, const egosieve_const_array* x,
                           egosieve_prediction* prediction);
absl::Status PredictGrid(const DevicePosterior& at, const egosieve_grid* grid,
                         egosieve_prediction* prediction);
absl::Status PredictImage(const DevicePosterior& at, const egosieve_image* image, int32_t stride,
                          egosieve_prediction* prediction);

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_PREDICTION_H_
