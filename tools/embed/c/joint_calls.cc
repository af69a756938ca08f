#include "tools/embed/c/host_prediction.h"
#include "tools/embed/c/model_handles.h"
#include "tools/embed/include/egosieve/joint_posterior.h"

using egosieve::embed::LearningModel;
using egosieve::embed::WithModel;

extern "C" {

egosieve_status egosieve_gp_predict_joint(egosieve_gp* gp, const egosieve_const_array* x,
                                          int32_t of_observation, const egosieve_array* mean,
                                          const egosieve_array* covariance) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return egosieve::embed::PredictJoint(model, x, of_observation != 0, mean, covariance);
  });
}

egosieve_status egosieve_gp_covariances(egosieve_gp* gp, const egosieve_const_array* x,
                                        const egosieve_const_array* z, const egosieve_array* k,
                                        const egosieve_array* by_logarithms,
                                        const egosieve_array* by_x) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return egosieve::embed::Covariances(model, x, z, k, by_logarithms, by_x);
  });
}

egosieve_status egosieve_gp_sample(egosieve_gp* gp, const egosieve_const_array* x, uint64_t seed,
                                   int32_t of_observation, const egosieve_array* samples,
                                   double* jitter) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return egosieve::embed::DrawSamples(model, x, seed, of_observation != 0, samples, jitter);
  });
}

egosieve_status egosieve_gp_gradients(egosieve_gp* gp, const egosieve_const_array* x,
                                      const egosieve_array* mean, const egosieve_array* variance) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return egosieve::embed::PredictGradients(model, x, mean, variance);
  });
}

egosieve_status egosieve_gp_leave_one_out(egosieve_gp* gp, const egosieve_array* mean,
                                          const egosieve_array* variance,
                                          const egosieve_array* log_density) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return egosieve::embed::LeaveOneOut(model, mean, variance, log_density);
  });
}

egosieve_status egosieve_gp_mean_coefficients(egosieve_gp* gp, const egosieve_array* coefficients) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return egosieve::embed::MeanCoefficients(model, coefficients);
  });
}

egosieve_status egosieve_gp_log_marginal_likelihood(egosieve_gp* gp, double* value) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return egosieve::embed::LogLikelihood(model, value);
  });
}

egosieve_status egosieve_gp_likelihood_at(egosieve_gp* gp, const double* theta, int64_t count,
                                          double* value, double* gradient) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return egosieve::embed::LikelihoodAt(model, theta, count, value, gradient);
  });
}

}  // extern "C"
