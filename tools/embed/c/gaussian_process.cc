#include "tools/embed/include/egosieve/gaussian_process.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/embed/c/array_access.h"
#include "tools/embed/c/device_contexts.h"
#include "tools/embed/c/last_error.h"
#include "tools/embed/c/learning_model.h"
#include "tools/embed/c/model_handles.h"
#include "tools/embed/c/model_options.h"
#include "tools/embed/c/options.h"

namespace egosieve::embed {
namespace {

// y: N x k; for one output also 1 x N.
absl::StatusOr<InputArray> TargetsOf(const egosieve_const_array* y, int64_t count) {
  EGOSIEVE_ASSIGN_OR_RETURN(const InputArray targets, InputArray::Matrix("y", y));
  if (targets.rows() == 1 && count != 1) return InputArray::Vector("y", y);
  return targets;
}

// The caller's points in float64, packed.
struct GivenPoints {
  std::vector<double> x, y, v;  // v: of the rows, empty where not given
  int64_t rows = 0, outputs = 0;

  static absl::StatusOr<GivenPoints> Read(const LearningModel& model, const egosieve_const_array* x,
                                          const egosieve_const_array* y, const char* v_name,
                                          const egosieve_const_array* v) {
    EGOSIEVE_ASSIGN_OR_RETURN(const InputArray inputs, InputArray::Matrix("x", x));
    EGOSIEVE_ASSIGN_OR_RETURN(const InputArray targets, TargetsOf(y, inputs.rows()));
    if (inputs.columns() != model.dimension()) {
      return absl::InvalidArgumentError(absl::StrFormat("x: %d columns; the model has %d inputs",
                                                        inputs.columns(), model.dimension()));
    }
    if (targets.rows() != inputs.rows()) {
      return absl::InvalidArgumentError(
          absl::StrFormat("y: %d values; x has %d rows", targets.rows(), inputs.rows()));
    }
    if (targets.rows() > 0 && targets.columns() < 1) {
      return absl::InvalidArgumentError("y: no columns");
    }
    // Queries are float32, so a point beyond its range could never be queried.
    EGOSIEVE_RETURN_IF_ERROR(inputs.CheckFinite<float>());
    EGOSIEVE_RETURN_IF_ERROR(targets.CheckFinite<double>());
    GivenPoints points{inputs.Values(), targets.Values(), {}, inputs.rows(), targets.columns()};
    if (v == nullptr) return points;
    EGOSIEVE_ASSIGN_OR_RETURN(const InputArray values, InputArray::Vector(v_name, v));
    if (values.rows() != inputs.rows()) {
      return absl::InvalidArgumentError(
          absl::StrFormat("%s: %d values; x has %d rows", v_name, values.rows(), inputs.rows()));
    }
    points.v = values.Values();
    for (size_t i = 0; i < points.v.size(); ++i) {
      if (!(points.v[i] >= 0.0 && std::isfinite(points.v[i]))) {
        return absl::InvalidArgumentError(absl::StrFormat(
            "%s(%d) = %g; it must be finite and not negative", v_name, i, points.v[i]));
      }
    }
    return points;
  }
  kernels::ConstMatrixView<double> inputs(const LearningModel& model) const {
    return {x.data(), rows, model.dimension()};
  }
};

// v null: the points have no noise of their own.
absl::Status ConditionOn(LearningModel& model, const egosieve_const_array* x,
                         const egosieve_const_array* y, const egosieve_const_array* v) {
  EGOSIEVE_ASSIGN_OR_RETURN(const GivenPoints points, GivenPoints::Read(model, x, y, "v", v));
  if (points.rows == 0) return absl::OkStatus();
  return model.Condition(
      {points.inputs(model), {points.y.data(), points.rows, points.outputs}, points.v});
}

gp::PointSet PointsOf(const LearningModel& model) {
  return model.With([](const auto& regression) { return regression.State().points; });
}

absl::Status CopyNoiseVariances(const LearningModel& model, const egosieve_array* v) {
  EGOSIEVE_RETURN_IF_ERROR(CheckPointer("v", v));
  gp::PointSet points = PointsOf(model);
  points.noise_variances.resize(points.size(), 0.0);
  EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray variances,
                            OutputArray::Create("v", *v, points.size(), 1));
  if (variances.wanted()) variances.Write(0, variances.size(), points.noise_variances.data());
  return absl::OkStatus();
}

absl::Status CopyPoints(const LearningModel& model, const egosieve_array* x,
                        const egosieve_array* y) {
  EGOSIEVE_RETURN_IF_ERROR(CheckPointer("x", x));
  EGOSIEVE_RETURN_IF_ERROR(CheckPointer("y", y));
  const gp::PointSet points = PointsOf(model);
  EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray inputs,
                            OutputArray::Create("x", *x, points.size(), model.dimension()));
  EGOSIEVE_ASSIGN_OR_RETURN(const OutputArray targets,
                            OutputArray::Create("y", *y, points.size(), points.outputs));
  if (inputs.wanted()) inputs.Write(0, inputs.size(), points.inputs.data());
  if (targets.wanted()) targets.Write(0, targets.size(), points.targets.data());
  return absl::OkStatus();
}

// Runs `search` with the options, null where the caller's are, and gives the caller its result.
template <typename Search>
absl::Status OptimizeBy(const LearningModel& model, const egosieve_optimize_options* options,
                        egosieve_optimize_result* result, const Search& run) {
  egosieve_optimize_options wishes;
  egosieve_optimize_options_init(&wishes);
  if (options != nullptr) EGOSIEVE_RETURN_IF_ERROR(ReadStruct("options", options, wishes));
  egosieve_optimize_result values{};
  if (result != nullptr) EGOSIEVE_RETURN_IF_ERROR(ReadStruct("result", result, values));
  SearchOptions search;
  search.subset_size = wishes.subset_size;
  search.restarts = wishes.restarts;
  search.gradient_steps = wishes.gradient_steps;
  search.tolerance = wishes.tolerance;
  search.seed = wishes.seed;
  const auto bounds = [&](const double* values) {
    return values == nullptr ? std::vector<double>()
                             : std::vector<double>(values, values + wishes.bound_count);
  };
  if (wishes.bound_count < 0) {
    return absl::InvalidArgumentError(
        absl::StrFormat("options.bound_count = %d", wishes.bound_count));
  }
  search.lower = bounds(wishes.lower_bounds);
  search.upper = bounds(wishes.upper_bounds);
  if (wishes.should_stop != nullptr) {
    search.should_stop = [&] { return wishes.should_stop(wishes.stop_argument) != 0; };
  }
  const int64_t count = model.Describe().hyperparameters.count();
  if (values.on_bound != nullptr && values.on_bound_count != count) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "result.on_bound_count = %d; there are %d hyperparameters", values.on_bound_count, count));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const SearchResult found, run(search));
  if (result == nullptr) return absl::OkStatus();
  values.log_likelihood_at_start = found.log_likelihood_at_start;
  values.log_likelihood = found.log_likelihood;
  values.evaluations = found.evaluations;
  values.points = found.points;
  values.converged = found.converged;
  values.gradient_norm = found.gradient_norm;
  if (values.on_bound != nullptr) {
    std::copy(found.on_bound.begin(), found.on_bound.end(), values.on_bound);
  }
  WriteStruct(values, result);
  return absl::OkStatus();
}

absl::Status Classify(LearningModel& model, const egosieve_const_array* x,
                      const egosieve_const_array* y, const egosieve_const_array* weights,
                      const egosieve_optimize_options* options, egosieve_optimize_result* result) {
  EGOSIEVE_ASSIGN_OR_RETURN(const GivenPoints points,
                            GivenPoints::Read(model, x, y, "weights", weights));
  if (points.outputs != 1 || points.rows == 0) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "y: %d x %d; labels are one column of at least one row", points.rows, points.outputs));
  }
  return OptimizeBy(model, options, result, [&](const SearchOptions& search) {
    return model.Classify({points.inputs(model), points.y, points.v},
                          options == nullptr ? nullptr : &search);
  });
}

egosieve_gp_info InfoOf(const LearningModel::Description& description) {
  egosieve_gp_info info{};
  const kernels::CovarianceParameters& covariance = description.hyperparameters.covariance;
  info.size = description.size;
  info.dimension = static_cast<int32_t>(covariance.input_dimension());
  info.covariance = covariance.function == kernels::CovarianceFunction::kArcsine ? EGOSIEVE_ARCSINE
                    : covariance.function == kernels::CovarianceFunction::kSquaredExponential
                        ? EGOSIEVE_SQUARED_EXPONENTIAL
                        : EGOSIEVE_NAMED_COVARIANCE;
  info.scale_count = static_cast<int64_t>(covariance.scales.size());
  std::copy_n(covariance.scales.begin(), std::min<int64_t>(info.scale_count, EGOSIEVE_INFO_SCALES),
              info.scales);
  info.signal_stddev = covariance.signal_stddev;
  info.noise_stddev = description.hyperparameters.noise_stddev;
  info.jitter = description.jitter;
  info.squash_a = description.squash.a;
  info.squash_b = description.squash.b;
  info.has_labels = description.has_labels;
  info.outputs = description.outputs;
  info.mean = static_cast<egosieve_mean>(description.hyperparameters.mean);
  info.coefficients =
      gp::CoefficientCount(description.hyperparameters.mean, covariance.input_dimension());
  if (description.sparse.has_value()) {
    info.approximation = description.sparse->approximation == gp::SparseApproximation::kFitc
                             ? EGOSIEVE_FITC
                             : EGOSIEVE_DTC;
    info.inducing_points = description.sparse->inducing_points;
  }
  info.inducing_count = description.inducing_size;
  return info;
}

}  // namespace
// More than any covariance has; a larger count is an error.
constexpr int64_t kMostScales = int64_t{1} << 20;

extern "C" {

void egosieve_gp_options_init(egosieve_gp_options* options) {
  if (options == nullptr) return;
  *options = egosieve_gp_options{};
  options->struct_size = sizeof *options;
  options->covariance = EGOSIEVE_ARCSINE;
  options->signal_stddev = 1.0;
  options->noise_stddev = 0.1;
  options->inducing_points = gp::SparseModelOptions().inducing_points;
}

void egosieve_gp_info_init(egosieve_gp_info* info) {
  if (info == nullptr) return;
  *info = egosieve_gp_info{};
  info->struct_size = sizeof *info;
}

void egosieve_optimize_options_init(egosieve_optimize_options* options) {
  if (options == nullptr) return;
  const SearchOptions defaults;
  *options = egosieve_optimize_options{};
  options->struct_size = sizeof *options;
  options->subset_size = defaults.subset_size;
  options->restarts = defaults.restarts;
  options->gradient_steps = defaults.gradient_steps;
  options->tolerance = defaults.tolerance;
  options->seed = defaults.seed;
}

void egosieve_optimize_result_init(egosieve_optimize_result* result) {
  if (result == nullptr) return;
  *result = egosieve_optimize_result{};
  result->struct_size = sizeof *result;
}

egosieve_status egosieve_gp_create(const egosieve_gp_options* options, egosieve_gp** gp) {
  return Guard(__func__, [&]() -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("gp", gp));
    egosieve_gp_options wishes;
    egosieve_gp_options_init(&wishes);
    EGOSIEVE_RETURN_IF_ERROR(ReadStruct("options", options, wishes));
    EGOSIEVE_ASSIGN_OR_RETURN(const auto hyperparameters, HyperparametersOf(wishes));
    EGOSIEVE_ASSIGN_OR_RETURN(const auto sparse, SparseOptionsOf(wishes));
    EGOSIEVE_ASSIGN_OR_RETURN(auto context,
                              wishes.opencl_context == nullptr
                                  ? ContextOf(wishes.device)
                                  : ContextOn(wishes.opencl_context, wishes.opencl_device));
    EGOSIEVE_ASSIGN_OR_RETURN(const auto dense, PosteriorOptionsOf(wishes));
    EGOSIEVE_ASSIGN_OR_RETURN(
        auto model, LearningModel::Create(std::move(context), hyperparameters, sparse, dense));
    EGOSIEVE_ASSIGN_OR_RETURN(*gp, AllModels().Insert(std::move(model)));
    return absl::OkStatus();
  });
}

egosieve_status egosieve_gp_free(egosieve_gp* gp) {
  if (gp == nullptr) return EGOSIEVE_OK;
  return Guard(__func__, [&] { return AllModels().Erase("gp", gp); });
}

egosieve_status egosieve_gp_condition(egosieve_gp* gp, const egosieve_const_array* x,
                                      const egosieve_const_array* y) {
  return WithModel(__func__, gp,
                   [&](LearningModel& model) { return ConditionOn(model, x, y, nullptr); });
}

egosieve_status egosieve_gp_condition_noisy(egosieve_gp* gp, const egosieve_const_array* x,
                                            const egosieve_const_array* y,
                                            const egosieve_const_array* v) {
  return WithModel(__func__, gp, [&](LearningModel& model) { return ConditionOn(model, x, y, v); });
}

egosieve_status egosieve_gp_remove(egosieve_gp* gp, const int64_t* rows, int64_t count) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    const int64_t size = model.Describe().size;
    if (count < 0 || count > size) {
      return absl::InvalidArgumentError(
          absl::StrFormat("count = %d; the model has %d points", count, size));
    }
    if (count == 0) return absl::OkStatus();
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("rows", rows));
    return model.Remove(std::vector<int64_t>(rows, rows + count));
  });
}

egosieve_status egosieve_gp_describe(egosieve_gp* gp, egosieve_gp_info* info) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckStruct("info", info));
    WriteStruct(InfoOf(model.Describe()), info);
    return absl::OkStatus();
  });
}

egosieve_status egosieve_gp_points(egosieve_gp* gp, const egosieve_array* x,
                                   const egosieve_array* y) {
  return WithModel(__func__, gp, [&](LearningModel& model) { return CopyPoints(model, x, y); });
}

egosieve_status egosieve_gp_noise_variances(egosieve_gp* gp, const egosieve_array* v) {
  return WithModel(__func__, gp,
                   [&](LearningModel& model) { return CopyNoiseVariances(model, v); });
}

egosieve_status egosieve_gp_scales(egosieve_gp* gp, double* scales, int64_t count) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    const std::vector<double> all = model.Describe().hyperparameters.covariance.scales;
    if (count < static_cast<int64_t>(all.size())) {
      return absl::InvalidArgumentError(
          absl::StrFormat("count = %d; there are %d scales", count, all.size()));
    }
    if (!all.empty()) EGOSIEVE_RETURN_IF_ERROR(CheckPointer("scales", scales));
    std::copy(all.begin(), all.end(), scales);
    return absl::OkStatus();
  });
}

egosieve_status egosieve_gp_covariance_text(egosieve_gp* gp, void* text, int64_t capacity,
                                            int64_t* size) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    const std::string name(model.Describe().hyperparameters.covariance.function.text());
    return GiveBytes(name, text, capacity, size);
  });
}

egosieve_status egosieve_gp_set_hyperparameters(egosieve_gp* gp, const double* scales,
                                                int64_t scale_count, double signal_stddev,
                                                double noise_stddev) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    if (scale_count < 0 || scale_count > kMostScales) {
      return absl::InvalidArgumentError(
          absl::StrFormat("scale_count = %d; it must be 0 to %d", scale_count, kMostScales));
    }
    if (scale_count > 0) EGOSIEVE_RETURN_IF_ERROR(CheckPointer("scales", scales));
    return model.SetHyperparameters(std::vector<double>(scales, scales + scale_count),
                                    signal_stddev, noise_stddev);
  });
}

egosieve_status egosieve_gp_optimize(egosieve_gp* gp, const egosieve_optimize_options* options,
                                     egosieve_optimize_result* result) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return OptimizeBy(model, options, result,
                      [&](const SearchOptions& search) { return model.Optimize(search); });
  });
}

egosieve_status egosieve_gp_classify(egosieve_gp* gp, const egosieve_const_array* x,
                                     const egosieve_const_array* y,
                                     const egosieve_const_array* weights,
                                     const egosieve_optimize_options* options,
                                     egosieve_optimize_result* result) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return Classify(model, x, y, weights, options, result);
  });
}

egosieve_status egosieve_gp_calibrate(egosieve_gp* gp) {
  return WithModel(__func__, gp, [](LearningModel& model) { return model.Calibrate(); });
}

}  // extern "C"

}  // namespace egosieve::embed
