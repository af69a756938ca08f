// Results that the model computes on the host, in float64, into the caller's arrays: joint
// predictions, samples, gradients, leave-one-out. All are computed before one is written.
#include <algorithm>
#include <type_traits>
#include <vector>

#include "gp/training/marginal_likelihood.h"
#include "gp/training/sparse_likelihood.h"
#include "kernels/ops/covariance_matrix.h"
#include "tools/embed/c/array_access.h"
#include "tools/embed/c/learning_model.h"
#include "tools/embed/include/egosieve/joint_posterior.h"

namespace egosieve::embed {
namespace {

// The caller's queries in float64, packed.
struct Queries {
  std::vector<double> values;
  int64_t rows, dimension;

  Queries(const LearningModel& model, const egosieve_const_array* x, const char* name = "x")
      : dimension(model.dimension()) {
    const auto points = InputArray::Points(name, x, dimension);
    points.CheckFinite<double>();
    values = points.Values();
    rows = points.rows();
  }
  kernels::ConstMatrixView<double> view() const { return {values.data(), rows, dimension}; }
};

// Calls `body` with the exact or sparse model behind `gp`.
template <typename Body>
egosieve_status WithRegression(const char* function, egosieve_gp* gp, const Body& body) {
  return With(function, gp, [&](LearningModel& model) { model.Visit(body); });
}

// The same with queries, and with the posterior in float64.
template <typename Body>
egosieve_status WithQueries(const char* function, egosieve_gp* gp, const egosieve_const_array* x,
                            const Body& body) {
  return With(function, gp, [&](LearningModel& model) {
    const Queries queries(model, x);
    model.Visit([&](const auto& regression) { body(regression, queries); });
  });
}

// Of a sparse model with its present inducing inputs.
template <typename Model>
gp::MarginalLikelihood LikelihoodOf(const Model& model, const gp::Hyperparameters& there,
                                    gp::LikelihoodOrder order) {
  kernels::Context& context = *model.context();
  gp::MarginalLikelihood nothing;
  if constexpr (std::is_same_v<Model, gp::ExactModel>) {
    return Take(gp::ComputeMarginalLikelihood(context, there, model.observations(), order));
  } else if constexpr (std::is_same_v<Model, gp::SparseModel>) {
    if (order == gp::LikelihoodOrder::kValueAndGradient) nothing.gradient.resize(there.count());
    if (model.size() == 0) return nothing;
    return Take(gp::ComputeSparseLikelihood(context, there, model.observations(),
                                            model.inducing_inputs(), order, model.options()));
  }
  Check(gp::NeedsFactor());
  return nothing;
}

}  // namespace

extern "C" {

egosieve_status egosieve_gp_predict_joint(egosieve_gp* gp, const egosieve_const_array* x,
                                          int32_t of_observation, const egosieve_array* mean,
                                          const egosieve_array* covariance) {
  return WithQueries(__func__, gp, x, [&](const auto& regression, const Queries& queries) {
    const int64_t rows = queries.rows;
    const OutputArray means("mean", mean, rows, regression.outputs());
    const OutputArray covariances("covariance", covariance, rows, rows);
    const auto posterior = Take(regression.MakeFloat64Posterior());
    gp::JointPrediction joint = Take(posterior->PredictJoint(queries.view()));
    for (int64_t i = 0; of_observation != 0 && i < rows; ++i) {
      joint.covariance.row(i)[i] += regression.hyperparameters().noise_variance();
    }
    means.Write(joint.mean);
    for (int64_t i = 0; covariances.wanted() && i < rows; ++i) {
      covariances.Write(i * rows, (i + 1) * rows, joint.covariance.row(i));
    }
  });
}

egosieve_status egosieve_gp_covariances(egosieve_gp* gp, const egosieve_const_array* x,
                                        const egosieve_const_array* z, const egosieve_array* k,
                                        const egosieve_array* by_logarithms,
                                        const egosieve_array* by_x) {
  return With(__func__, gp, [&](LearningModel& model) {
    const Queries left(model, x), right = z == nullptr ? left : Queries(model, z, "z");
    const kernels::CovarianceParameters parameters = model.hyperparameters().covariance;
    const int64_t logarithms = static_cast<int64_t>(parameters.scales.size()) + 1;
    const int64_t pairs = left.rows * right.rows, dimension = model.dimension();
    const OutputArray values("k", k, left.rows, right.rows);
    const OutputArray of_logarithms("by_logarithms", by_logarithms, pairs, logarithms);
    const OutputArray of_x("by_x", by_x, pairs, dimension);
    const auto room = [](const OutputArray& output) {
      return std::vector<double>(output.wanted() ? output.size() : 0);
    };
    std::vector<double> block = room(values), logarithm = room(of_logarithms), input = room(of_x);
    if (values.wanted()) {
      Check(kernels::CrossCovariance(*model.context(), parameters, left.view(), right.view(),
                                     {block.data(), left.rows, right.rows}));
    }
    Check(kernels::CovarianceDerivatives(parameters, left.view(), right.view(),
                                         {logarithm.data(), pairs, logarithms},
                                         {input.data(), pairs, dimension}));
    values.Write(block);
    of_logarithms.Write(logarithm);
    of_x.Write(input);
  });
}

egosieve_status egosieve_gp_sample(egosieve_gp* gp, const egosieve_const_array* x, uint64_t seed,
                                   int32_t of_observation, const egosieve_array* samples,
                                   double* jitter) {
  return WithQueries(__func__, gp, x, [&](const auto& regression, const Queries& queries) {
    RequirePointer("samples", samples);
    gp::SampleOptions options;
    options.count = samples->columns;
    options.seed = seed;
    options.of_observation = of_observation != 0;
    const int64_t k = regression.outputs();
    const OutputArray output("samples", samples, queries.rows * k, options.count);
    Require(output.wanted(), "samples.data is null");
    const auto posterior = Take(regression.MakeFloat64Posterior());
    const gp::NormalSamples drawn = Take(posterior->Sample(queries.view(), options));
    for (int64_t i = 0; i < queries.rows; ++i) {  // a row of k S values is written as k rows of S
      output.Write(i * k * options.count, (i + 1) * k * options.count, drawn.values.row(i));
    }
    if (jitter != nullptr) *jitter = drawn.jitter;
  });
}

egosieve_status egosieve_gp_sample_paths(egosieve_gp* gp, const egosieve_const_array* x,
                                         uint64_t seed, int64_t frequencies, int32_t of_observation,
                                         const egosieve_array* samples) {
  return WithQueries(__func__, gp, x, [&](const auto& regression, const Queries& queries) {
    RequirePointer("samples", samples);
    const gp::PathOptions options = {samples->columns, frequencies, seed, of_observation != 0};
    const OutputArray output("samples", samples, queries.rows * regression.outputs(),
                             options.count);
    Require(output.wanted(), "samples.data is null");
    const auto paths = Take(regression.DrawPaths(options));
    output.Write(Take(paths->Evaluate(queries.view())));
  });
}

egosieve_status egosieve_gp_gradients(egosieve_gp* gp, const egosieve_const_array* x,
                                      const egosieve_array* mean, const egosieve_array* variance) {
  return WithQueries(__func__, gp, x, [&](const auto& regression, const Queries& queries) {
    const int64_t rows = queries.rows;
    const OutputArray of_mean("mean", mean, rows * regression.outputs(), queries.dimension);
    const OutputArray of_variance("variance", variance, rows, queries.dimension);
    const auto what =
        of_variance.wanted() ? gp::PredictWhat::kMeanAndVariance : gp::PredictWhat::kMean;
    const auto posterior = Take(regression.MakeFloat64Posterior());
    const gp::InputGradients gradients = Take(posterior->PredictGradients(queries.view(), what));
    of_mean.Write(gradients.mean);
    of_variance.Write(gradients.variance);
  });
}

egosieve_status egosieve_gp_leave_one_out(egosieve_gp* gp, const egosieve_array* mean,
                                          const egosieve_array* variance,
                                          const egosieve_array* log_density) {
  return WithRegression(__func__, gp, [&](const auto& regression) {
    const int64_t n = regression.size(), k = regression.outputs();
    const OutputArray means("mean", mean, n, k), variances("variance", variance, n, 1);
    const OutputArray densities("log_density", log_density, n, k);
    const auto left_out = Take<gp::LeaveOneOut>(regression.PredictLeaveOneOut());
    const std::vector<double> of_targets = left_out.LogDensities(regression.targets());
    means.Write(left_out.mean);
    variances.Write(left_out.target_variance);
    densities.Write(of_targets);
  });
}

egosieve_status egosieve_gp_mean_coefficients(egosieve_gp* gp, const egosieve_array* coefficients) {
  return WithRegression(__func__, gp, [&](const auto& regression) {
    gp::RegressionWeights weights;  // of the zero mean, which other models have
    if constexpr (requires { regression.weights(); }) weights = regression.weights();
    const OutputArray output("coefficients", coefficients, weights.basis, regression.outputs());
    Check(weights.CheckDetermined());
    output.Write(weights.coefficients);
  });
}

egosieve_status egosieve_gp_log_marginal_likelihood(egosieve_gp* gp, double* value) {
  return WithRegression(__func__, gp, [&](const auto& regression) {
    RequirePointer("value", value);
    if constexpr (std::is_same_v<std::decay_t<decltype(regression)>, gp::ExactModel>) {
      *value = regression.LogMarginalLikelihood();
    } else {
      *value =
          LikelihoodOf(regression, regression.hyperparameters(), gp::LikelihoodOrder::kValue).value;
    }
  });
}

egosieve_status egosieve_gp_likelihood_at(egosieve_gp* gp, const double* theta, int64_t count,
                                          double* value, double* gradient) {
  return WithRegression(__func__, gp, [&](const auto& regression) {
    RequirePointer("theta", theta);
    RequirePointer("value", value);
    const gp::Hyperparameters& own = regression.hyperparameters();
    Require(count == own.count(), "count = %d; theta has %d values", count, own.count());
    const auto there = Take(gp::FromLogarithms(own, absl::MakeConstSpan(theta, count)));
    const auto likelihood = LikelihoodOf(
        regression, there,
        gradient == nullptr ? gp::LikelihoodOrder::kValue : gp::LikelihoodOrder::kValueAndGradient);
    *value = likelihood.value;
    if (gradient == nullptr) return;
    std::copy(likelihood.gradient.begin(), likelihood.gradient.end(), gradient);
  });
}

}  // extern "C"

}  // namespace egosieve::embed
