// Results that the model computes on the host, in float64, into the caller's arrays: joint
// predictions, samples, gradients, leave-one-out. Nothing is written until all results are
// computed.
#include <algorithm>
#include <vector>

#include "absl/strings/str_format.h"
#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "gp/training/marginal_likelihood.h"
#include "gp/training/sparse_likelihood.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/input_gradient.h"
#include "tools/embed/c/array_access.h"
#include "tools/embed/c/model_handles.h"
#include "tools/embed/c/options.h"
#include "tools/embed/include/egosieve/joint_posterior.h"

namespace egosieve::embed {
namespace {

using gp::PredictWhat;

// The caller's queries in float64, packed.
struct Queries {
  std::vector<double> values;
  int64_t rows = 0;
  int64_t dimension = 0;

  static absl::StatusOr<Queries> Read(const LearningModel& model, const egosieve_const_array* x,
                                      const char* name = "x") {
    EGOSIEVE_ASSIGN_OR_RETURN(const InputArray points, InputArray::Matrix(name, x));
    if (points.columns() != model.dimension()) {
      return absl::InvalidArgumentError(absl::StrFormat("%s: %d columns; the model has %d inputs",
                                                        name, points.columns(), model.dimension()));
    }
    EGOSIEVE_RETURN_IF_ERROR(points.CheckFinite<double>());
    return Queries{points.Values(), points.rows(), points.columns()};
  }
  kernels::ConstMatrixView<double> view() const { return {values.data(), rows, dimension}; }
};

// An output of this shape; null pointers are refused.
absl::StatusOr<OutputArray> OutputOf(const char* name, const egosieve_array* array, int64_t rows,
                                     int64_t columns) {
  EGOSIEVE_RETURN_IF_ERROR(CheckPointer(name, array));
  return OutputArray::Create(name, *array, rows, columns);
}

void WriteWanted(const std::vector<double>& values, const OutputArray& output) {
  if (output.wanted()) output.Write(0, output.size(), values.data());
}

absl::Status WriteCoefficients(const gp::ExactModel& model, const egosieve_array* coefficients) {
  const gp::RegressionWeights& weights = model.weights();
  EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray output,
                            OutputOf("coefficients", coefficients, weights.basis, weights.outputs));
  EGOSIEVE_RETURN_IF_ERROR(weights.CheckDetermined());
  WriteWanted(weights.coefficients, output);
  return absl::OkStatus();
}

// A sparse model has the zero mean, and so no coefficients.
absl::Status WriteCoefficients(const gp::SparseModel&, const egosieve_array* coefficients) {
  return OutputOf("coefficients", coefficients, 0, 1).status();
}

absl::StatusOr<gp::MarginalLikelihood> LikelihoodOf(const gp::ExactModel& model,
                                                    const gp::Hyperparameters& there,
                                                    gp::LikelihoodOrder order) {
  return gp::ComputeMarginalLikelihood(*model.context(), there, model.observations(), order);
}

// Uses the model's present inducing inputs.
absl::StatusOr<gp::MarginalLikelihood> LikelihoodOf(const gp::SparseModel& model,
                                                    const gp::Hyperparameters& there,
                                                    gp::LikelihoodOrder order) {
  if (model.size() == 0) {
    gp::MarginalLikelihood nothing;
    if (order == gp::LikelihoodOrder::kValueAndGradient) nothing.gradient.resize(there.count());
    return nothing;
  }
  return gp::ComputeSparseLikelihood(*model.context(), there, model.observations(),
                                     model.inducing_inputs(), order,
                                     SparseObjectiveOf(model.options()));
}

absl::StatusOr<double> OwnLikelihood(const gp::ExactModel& model) {
  return model.LogMarginalLikelihood();
}

absl::StatusOr<double> OwnLikelihood(const gp::SparseModel& model) {
  EGOSIEVE_ASSIGN_OR_RETURN(
      const gp::MarginalLikelihood likelihood,
      LikelihoodOf(model, model.hyperparameters(), gp::LikelihoodOrder::kValue));
  return likelihood.value;
}

}  // namespace

extern "C" {

egosieve_status egosieve_gp_predict_joint(egosieve_gp* gp, const egosieve_const_array* x,
                                          int32_t of_observation, const egosieve_array* mean,
                                          const egosieve_array* covariance) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const Queries queries, Queries::Read(model, x));
    return model.With([&](const auto& regression) -> absl::Status {
      EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray means,
                                OutputOf("mean", mean, queries.rows, regression.outputs()));
      EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray covariances,
                                OutputOf("covariance", covariance, queries.rows, queries.rows));
      EGOSIEVE_ASSIGN_OR_RETURN(const auto posterior, regression.MakeFloat64Posterior());
      EGOSIEVE_ASSIGN_OR_RETURN(gp::JointPrediction joint, posterior->PredictJoint(queries.view()));
      for (int64_t i = 0; of_observation != 0 && i < queries.rows; ++i) {
        joint.covariance.row(i)[i] += regression.hyperparameters().noise_variance();
      }
      WriteWanted(joint.mean, means);
      for (int64_t i = 0; covariances.wanted() && i < queries.rows; ++i) {
        covariances.Write(i * queries.rows, (i + 1) * queries.rows, joint.covariance.row(i));
      }
      return absl::OkStatus();
    });
  });
}

egosieve_status egosieve_gp_covariances(egosieve_gp* gp, const egosieve_const_array* x,
                                        const egosieve_const_array* z, const egosieve_array* k,
                                        const egosieve_array* by_logarithms,
                                        const egosieve_array* by_x) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const Queries left, Queries::Read(model, x));
    EGOSIEVE_ASSIGN_OR_RETURN(const Queries right,
                              z == nullptr ? left : Queries::Read(model, z, "z"));
    const kernels::CovarianceParameters parameters = model.Describe().hyperparameters.covariance;
    const int64_t logarithms = static_cast<int64_t>(parameters.scales.size()) + 1;
    const int64_t pairs = left.rows * right.rows;
    EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray values, OutputOf("k", k, left.rows, right.rows));
    EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray of_logarithms,
                              OutputOf("by_logarithms", by_logarithms, pairs, logarithms));
    EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray of_x,
                              OutputOf("by_x", by_x, pairs, model.dimension()));
    const auto room = [&](const OutputArray& output, int64_t columns) {
      return std::vector<double>(output.wanted() ? pairs * columns : 0);
    };
    std::vector<double> block = room(values, 1), logarithm = room(of_logarithms, logarithms),
                        input = room(of_x, model.dimension());
    if (values.wanted()) {
      EGOSIEVE_RETURN_IF_ERROR(
          kernels::CrossCovariance<double>(*model.context(), parameters, left.view(), right.view(),
                                           {block.data(), left.rows, right.rows}));
    }
    EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceDerivatives(
        parameters, left.view(), right.view(), {logarithm.data(), pairs, logarithms},
        {input.data(), pairs, model.dimension()}));
    WriteWanted(block, values);
    WriteWanted(logarithm, of_logarithms);
    WriteWanted(input, of_x);
    return absl::OkStatus();
  });
}

egosieve_status egosieve_gp_sample(egosieve_gp* gp, const egosieve_const_array* x, uint64_t seed,
                                   int32_t of_observation, const egosieve_array* samples,
                                   double* jitter) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const Queries queries, Queries::Read(model, x));
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("samples", samples));
    return model.With([&](const auto& regression) -> absl::Status {
      const int64_t k = regression.outputs();
      EGOSIEVE_ASSIGN_OR_RETURN(
          const OutputArray output,
          OutputArray::Create("samples", *samples, queries.rows * k, samples->columns));
      if (!output.wanted()) return absl::InvalidArgumentError("samples.data is null");
      gp::SampleOptions options;
      options.count = samples->columns;
      options.seed = seed;
      options.of_observation = of_observation != 0;
      EGOSIEVE_ASSIGN_OR_RETURN(const auto posterior, regression.MakeFloat64Posterior());
      EGOSIEVE_ASSIGN_OR_RETURN(const gp::NormalSamples drawn,
                                posterior->Sample(queries.view(), options));
      for (int64_t i = 0; i < queries.rows; ++i) {  // a row of k S values is written as k rows of S
        output.Write(i * k * options.count, (i + 1) * k * options.count, drawn.values.row(i));
      }
      if (jitter != nullptr) *jitter = drawn.jitter;
      return absl::OkStatus();
    });
  });
}

egosieve_status egosieve_gp_gradients(egosieve_gp* gp, const egosieve_const_array* x,
                                      const egosieve_array* mean, const egosieve_array* variance) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const Queries queries, Queries::Read(model, x));
    return model.With([&](const auto& regression) -> absl::Status {
      EGOSIEVE_ASSIGN_OR_RETURN(
          const OutputArray of_mean,
          OutputOf("mean", mean, queries.rows * regression.outputs(), queries.dimension));
      EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray of_variance,
                                OutputOf("variance", variance, queries.rows, queries.dimension));
      EGOSIEVE_ASSIGN_OR_RETURN(const auto posterior, regression.MakeFloat64Posterior());
      EGOSIEVE_ASSIGN_OR_RETURN(
          const gp::InputGradients gradients,
          posterior->PredictGradients(queries.view(), of_variance.wanted()
                                                          ? PredictWhat::kMeanAndVariance
                                                          : PredictWhat::kMean));
      WriteWanted(gradients.mean, of_mean);
      WriteWanted(gradients.variance, of_variance);
      return absl::OkStatus();
    });
  });
}

egosieve_status egosieve_gp_leave_one_out(egosieve_gp* gp, const egosieve_array* mean,
                                          const egosieve_array* variance,
                                          const egosieve_array* log_density) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    return model.With([&](const auto& regression) -> absl::Status {
      const int64_t n = regression.size(), k = regression.outputs();
      EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray means, OutputOf("mean", mean, n, k));
      EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray variances, OutputOf("variance", variance, n, 1));
      EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray densities,
                                OutputOf("log_density", log_density, n, k));
      EGOSIEVE_ASSIGN_OR_RETURN(const gp::LeaveOneOut left_out, LeaveOneOutOf(regression));
      const std::vector<double> of_targets = left_out.LogDensities(regression.targets());
      WriteWanted(left_out.mean, means);
      WriteWanted(left_out.target_variance, variances);
      WriteWanted(of_targets, densities);
      return absl::OkStatus();
    });
  });
}

egosieve_status egosieve_gp_mean_coefficients(egosieve_gp* gp, const egosieve_array* coefficients) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    return model.With(
        [&](const auto& regression) { return WriteCoefficients(regression, coefficients); });
  });
}

egosieve_status egosieve_gp_log_marginal_likelihood(egosieve_gp* gp, double* value) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("value", value));
    return model.With([&](const auto& regression) -> absl::Status {
      EGOSIEVE_ASSIGN_OR_RETURN(*value, OwnLikelihood(regression));
      return absl::OkStatus();
    });
  });
}

egosieve_status egosieve_gp_likelihood_at(egosieve_gp* gp, const double* theta, int64_t count,
                                          double* value, double* gradient) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("theta", theta));
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("value", value));
    return model.With([&](const auto& regression) -> absl::Status {
      if (count != regression.hyperparameters().count()) {
        return absl::InvalidArgumentError(absl::StrFormat("count = %d; theta has %d values", count,
                                                          regression.hyperparameters().count()));
      }
      EGOSIEVE_ASSIGN_OR_RETURN(
          const gp::Hyperparameters there,
          gp::FromLogarithms(regression.hyperparameters(), absl::MakeConstSpan(theta, count)));
      EGOSIEVE_ASSIGN_OR_RETURN(
          const gp::MarginalLikelihood likelihood,
          LikelihoodOf(regression, there,
                       gradient == nullptr ? gp::LikelihoodOrder::kValue
                                           : gp::LikelihoodOrder::kValueAndGradient));
      *value = likelihood.value;
      if (gradient != nullptr) {
        std::copy(likelihood.gradient.begin(), likelihood.gradient.end(), gradient);
      }
      return absl::OkStatus();
    });
  });
}

}  // extern "C"

}  // namespace egosieve::embed
