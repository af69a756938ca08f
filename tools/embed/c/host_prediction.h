// Results that the model computes on the host, in float64, into the caller's arrays: joint
// predictions, samples, gradients, leave-one-out. Nothing is written until all results are
// computed.
#ifndef EGOSIEVE_TOOLS_EMBED_C_HOST_PREDICTION_H_
#define EGOSIEVE_TOOLS_EMBED_C_HOST_PREDICTION_H_

#include <cstdint>

#include "absl/status/status.h"
#include "tools/embed/c/learning_model.h"
#include "tools/embed/include/egosieve/joint_posterior.h"

namespace egosieve::embed {

// Each does the work of the C function of that name; errors name its arguments.
absl::Status PredictJoint(const LearningModel& model, const egosieve_const_array* x,
                          bool of_observation, const egosieve_array* mean,
                          const egosieve_array* covariance);
absl::Status Covariances(const LearningModel& model, const egosieve_const_array* x,
                         const egosieve_const_array* z, const egosieve_array* k,
                         const egosieve_array* by_logarithms, const egosieve_array* by_x);
absl::Status DrawSamples(const LearningModel& model, const egosieve_const_array* x, uint64_t seed,
                         bool of_observation, const egosieve_array* samples, double* jitter);
absl::Status PredictGradients(const LearningModel& model, const egosieve_const_array* x,
                              const egosieve_array* mean, const egosieve_array* variance);
absl::Status LeaveOneOut(const LearningModel& model, const egosieve_array* mean,
                         const egosieve_array* variance, const egosieve_array* log_density);
absl::Status MeanCoefficients(const LearningModel& model, const egosieve_array* coefficients);
absl::Status LogLikelihood(const LearningModel& model, double* value);
absl::Status LikelihoodAt(const LearningModel& model, const double* theta, int64_t count,
                          double* value, double* gradient);

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_HOST_PREDICTION_H_
