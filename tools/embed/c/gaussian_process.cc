#include "tools/embed/include/egosieve/gaussian_process.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "gp/io/model_file.h"
#include "tools/embed/c/array_access.h"
#include "tools/embed/c/device_contexts.h"
#include "tools/embed/c/learning_model.h"

namespace egosieve::embed {
namespace {

static_assert(EGOSIEVE_MAX_DIMENSION == kernels::kMaxInputDimension);
static_assert(EGOSIEVE_ZERO_MEAN == static_cast<int>(gp::MeanFunction::kZero) &&
              EGOSIEVE_CONSTANT_MEAN == static_cast<int>(gp::MeanFunction::kConstant) &&
              EGOSIEVE_LINEAR_MEAN == static_cast<int>(gp::MeanFunction::kLinear));

// More than any covariance has; a larger count is an error.
constexpr int64_t kMostScales = int64_t{1} << 20;

kernels::CovarianceFunction CovarianceOf(const egosieve_gp_options& options) {
  const std::string text = options.covariance_text == nullptr ? "" : options.covariance_text;
  const egosieve_covariance kind = options.covariance;
  Require(kind >= EGOSIEVE_ARCSINE && kind <= EGOSIEVE_NAMED_COVARIANCE,
          "options.covariance = %d; it must be EGOSIEVE_ARCSINE, EGOSIEVE_SQUARED_EXPONENTIAL or "
          "EGOSIEVE_NAMED_COVARIANCE",
          kind);
  if (text.empty() && kind == EGOSIEVE_ARCSINE) return kernels::CovarianceFunction::kArcsine;
  if (kind == EGOSIEVE_SQUARED_EXPONENTIAL) {
    Require(text.empty(), "options.covariance = %d and covariance_text = \"%s\"; set one", kind,
            text);
    return kernels::CovarianceFunction::kSquaredExponential;
  }
  RequirePointer("options.covariance_text", options.covariance_text);
  return Take(kernels::CovarianceFunction::Parse(text));
}

gp::Hyperparameters HyperparametersOf(const egosieve_gp_options& options) {
  const kernels::CovarianceFunction function = CovarianceOf(options);
  Require(options.mean >= EGOSIEVE_ZERO_MEAN && options.mean <= EGOSIEVE_LINEAR_MEAN,
          "options.mean = %d; it must be EGOSIEVE_ZERO_MEAN, EGOSIEVE_CONSTANT_MEAN or "
          "EGOSIEVE_LINEAR_MEAN",
          options.mean);
  Require(options.dimension >= 1 && options.dimension <= EGOSIEVE_MAX_DIMENSION,
          "options.dimension = %d; it must be 1 to %d", options.dimension, EGOSIEVE_MAX_DIMENSION);
  gp::Hyperparameters hyperparameters = gp::DefaultHyperparameters(function, options.dimension);
  std::vector<double>& scales = hyperparameters.covariance.scales;
  const int64_t expected = options.scales == nullptr ? 0 : static_cast<int64_t>(scales.size());
  Require(options.scale_count == expected,
          "options.scale_count = %d; %s of %d inputs has %d scales", options.scale_count,
          function.text(), options.dimension, scales.size());
  if (options.scales != nullptr) scales.assign(options.scales, options.scales + expected);
  hyperparameters.covariance.signal_stddev = options.signal_stddev;
  hyperparameters.noise_stddev = options.noise_stddev;
  hyperparameters.mean = static_cast<gp::MeanFunction>(options.mean);
  Check(hyperparameters.Validate());
  return hyperparameters;
}

// Makes `file` that of a sparse or an iterative model where the options say so.
void TakeApproximation(const egosieve_gp_options& options, gp::ModelFile& file) {
  if (options.approximation == EGOSIEVE_EXACT) return;
  Require(options.approximation >= EGOSIEVE_DTC && options.approximation <= EGOSIEVE_ITERATIVE,
          "options.approximation = %d; it must be EGOSIEVE_EXACT, EGOSIEVE_DTC, EGOSIEVE_FITC or "
          "EGOSIEVE_ITERATIVE",
          options.approximation);
  if (options.approximation == EGOSIEVE_ITERATIVE) {
    Require(options.inducing_points >= 1, "options.inducing_points = %d; it must be positive",
            options.inducing_points);
    gp::IterativeModelOptions& iterative = file.iterative.emplace().options;
    iterative.rank = options.inducing_points;
    iterative.gradients.tolerance = options.tolerance;
    return;
  }
  gp::SparseModelOptions& sparse = file.sparse.emplace();
  sparse.approximation = options.approximation == EGOSIEVE_DTC ? gp::SparseApproximation::kDtc
                                                               : gp::SparseApproximation::kFitc;
  sparse.inducing_points = options.inducing_points;
}

std::shared_ptr<LearningModel> ModelOf(const egosieve_gp_options& options) {
  gp::ModelFile file;
  file.model.hyperparameters = HyperparametersOf(options);
  TakeApproximation(options, file);
  auto context = Take(options.opencl_context == nullptr
                          ? ContextOf(options.device)
                          : ContextOn(options.opencl_context, options.opencl_device));
  Require(options.memory_cap_bytes >= 0, "options.memory_cap_bytes = %d; it must not be negative",
          options.memory_cap_bytes);
  return LearningModel::Create(std::move(context), std::move(file), {options.memory_cap_bytes});
}

// The caller's points in float64, packed. y: N x k or, for one output, 1 x N. v: empty if null.
struct GivenPoints {
  std::vector<double> x, y, v;
  int64_t rows, outputs, dimension;

  GivenPoints(const LearningModel& model, const egosieve_const_array* given_x,
              const egosieve_const_array* given_y, const char* v_name,
              const egosieve_const_array* given_v)
      : dimension(model.dimension()) {
    const auto inputs = InputArray::Points("x", given_x, dimension);
    InputArray targets("y", given_y);
    rows = inputs.rows();
    if (targets.rows() == 1 && rows != 1) targets = InputArray::Vector("y", given_y);
    Require(targets.rows() == rows, "y: %d values; x has %d rows", targets.rows(), rows);
    Require(rows == 0 || targets.columns() >= 1, "y: no columns");
    inputs.CheckFinite<float>();  // queries are float32: a point beyond could
                                  // never be queried
    targets.CheckFinite<double>();
    x = inputs.Values();
    y = targets.Values();
    outputs = targets.columns();
    if (given_v == nullptr) return;
    const auto values = InputArray::Vector(v_name, given_v);
    Require(values.rows() == rows, "%s: %d values; x has %d rows", v_name, values.rows(), rows);
    v = values.Values();
    for (size_t i = 0; i < v.size(); ++i) {
      Require(v[i] >= 0.0 && std::isfinite(v[i]), "%s(%d) = %g; it must be finite and not negative",
              v_name, i, v[i]);
    }
  }
  kernels::ConstMatrixView<double> inputs() const { return {x.data(), rows, dimension}; }
};

egosieve_status Condition(const char* function, egosieve_gp* gp, const egosieve_const_array* x,
                          const egosieve_const_array* y, const egosieve_const_array* v) {
  return With(function, gp, [&](LearningModel& model) {
    const GivenPoints points(model, x, y, "v", v);
    if (points.rows == 0) return;
    model.Condition({points.inputs(), {points.y.data(), points.rows, points.outputs}, points.v});
  });
}

gp::PointSet PointsOf(const LearningModel& model) {
  return model.Visit([](const auto& regression) { return regression.State().points; });
}

// Calls `run` with the options and gives the caller its result.
template <typename Run>
void SearchBy(const LearningModel& model, const egosieve_optimize_options* options,
              egosieve_optimize_result* result, const Run& run) {
  const auto wishes = Read("options", options, egosieve_optimize_options_init, /*optional=*/true);
  const auto values = Read("result", result, egosieve_optimize_result_init, /*optional=*/true);
  const int64_t count = model.hyperparameters().count();
  Require(values.on_bound == nullptr || values.on_bound_count == count,
          "result.on_bound_count = %d; there are %d hyperparameters", values.on_bound_count, count);
  SearchResult found = run(wishes);
  if (result == nullptr) return;
  if (values.on_bound != nullptr) {
    std::copy(found.on_bound.begin(), found.on_bound.end(), values.on_bound);
  }
  found.account.on_bound = values.on_bound;
  found.account.on_bound_count = values.on_bound_count;
  WriteStruct(found.account, result);
}

}  // namespace

extern "C" {

void egosieve_gp_options_init(egosieve_gp_options* options) {
  if (!Initialise(options)) return;
  options->signal_stddev = 1.0;
  options->noise_stddev = 0.1;
  options->inducing_points = gp::SparseModelOptions().inducing_points;
  options->tolerance = gp::ConjugateGradientOptions().tolerance;
}

void egosieve_gp_info_init(egosieve_gp_info* info) { Initialise(info); }

void egosieve_optimize_options_init(egosieve_optimize_options* options) {
  if (!Initialise(options)) return;
  options->subset_size = 800;
  options->gradient_steps = 500;
  options->tolerance = 1e-3;
  options->seed = 1;
}

void egosieve_optimize_result_init(egosieve_optimize_result* result) { Initialise(result); }

egosieve_status egosieve_gp_create(const egosieve_gp_options* options, egosieve_gp** gp) {
  return New(__func__, gp,
             [&] { return ModelOf(Read("options", options, egosieve_gp_options_init)); });
}

egosieve_status egosieve_gp_free(egosieve_gp* gp) { return Free(__func__, gp); }

egosieve_status egosieve_gp_condition(egosieve_gp* gp, const egosieve_const_array* x,
                                      const egosieve_const_array* y) {
  return Condition(__func__, gp, x, y, nullptr);
}

egosieve_status egosieve_gp_condition_noisy(egosieve_gp* gp, const egosieve_const_array* x,
                                            const egosieve_const_array* y,
                                            const egosieve_const_array* v) {
  return Condition(__func__, gp, x, y, v);
}

egosieve_status egosieve_gp_remove(egosieve_gp* gp, const int64_t* rows, int64_t count) {
  return With(__func__, gp, [&](LearningModel& model) {
    const int64_t size = model.Describe().size;
    Require(count >= 0 && count <= size, "count = %d; the model has %d points", count, size);
    if (count == 0) return;
    RequirePointer("rows", rows);
    model.Remove(std::vector<int64_t>(rows, rows + count));
  });
}

egosieve_status egosieve_gp_describe(egosieve_gp* gp, egosieve_gp_info* info) {
  return With(__func__, gp, [&](LearningModel& model) {
    CheckStruct("info", info);
    WriteStruct(model.Describe(), info);
  });
}

egosieve_status egosieve_gp_points(egosieve_gp* gp, const egosieve_array* x,
                                   const egosieve_array* y) {
  return With(__func__, gp, [&](LearningModel& model) {
    const gp::PointSet points = PointsOf(model);
    const OutputArray inputs("x", x, points.size(), model.dimension());
    const OutputArray targets("y", y, points.size(), points.outputs);
    inputs.Write(points.inputs);
    targets.Write(points.targets);
  });
}

egosieve_status egosieve_gp_noise_variances(egosieve_gp* gp, const egosieve_array* v) {
  return With(__func__, gp, [&](LearningModel& model) {
    gp::PointSet points = PointsOf(model);
    points.noise_variances.resize(points.size(), 0.0);
    OutputArray("v", v, points.size(), 1).Write(points.noise_variances);
  });
}

egosieve_status egosieve_gp_scales(egosieve_gp* gp, double* scales, int64_t count) {
  return With(__func__, gp, [&](LearningModel& model) {
    const std::vector<double> all = model.hyperparameters().covariance.scales;
    Require(count >= static_cast<int64_t>(all.size()), "count = %d; there are %d scales", count,
            all.size());
    if (!all.empty()) RequirePointer("scales", scales);
    std::copy(all.begin(), all.end(), scales);
  });
}

egosieve_status egosieve_gp_covariance_text(egosieve_gp* gp, void* text, int64_t capacity,
                                            int64_t* size) {
  return With(__func__, gp, [&](LearningModel& model) {
    GiveBytes(model.hyperparameters().covariance.function.text(), text, capacity, size);
  });
}

egosieve_status egosieve_gp_set_hyperparameters(egosieve_gp* gp, const double* scales,
                                                int64_t scale_count, double signal_stddev,
                                                double noise_stddev) {
  return With(__func__, gp, [&](LearningModel& model) {
    Require(scale_count >= 0 && scale_count <= kMostScales, "scale_count = %d; it must be 0 to %d",
            scale_count, kMostScales);
    if (scale_count > 0) RequirePointer("scales", scales);
    model.SetHyperparameters({scales, scales + scale_count}, signal_stddev, noise_stddev);
  });
}

egosieve_status egosieve_gp_optimize(egosieve_gp* gp, const egosieve_optimize_options* options,
                                     egosieve_optimize_result* result) {
  return With(__func__, gp, [&](LearningModel& model) {
    SearchBy(model, options, result,
             [&](const egosieve_optimize_options& search) { return model.Optimize(search); });
  });
}

egosieve_status egosieve_gp_classify(egosieve_gp* gp, const egosieve_const_array* x,
                                     const egosieve_const_array* y,
                                     const egosieve_const_array* weights,
                                     const egosieve_optimize_options* options,
                                     egosieve_optimize_result* result) {
  return With(__func__, gp, [&](LearningModel& model) {
    const GivenPoints points(model, x, y, "weights", weights);
    Require(points.outputs == 1 && points.rows > 0,
            "y: %d x %d; labels are one column of at least one row", points.rows, points.outputs);
    SearchBy(model, options, result, [&](const egosieve_optimize_options& search) {
      return model.Classify({points.inputs(), points.y, points.v},
                            options == nullptr ? nullptr : &search);
    });
  });
}

egosieve_status egosieve_gp_calibrate(egosieve_gp* gp) {
  return With(__func__, gp, [](LearningModel& model) { model.Calibrate(); });
}

egosieve_status egosieve_gp_set_annotation(egosieve_gp* gp, const void* bytes, int64_t size) {
  return With(__func__, gp, [&](LearningModel& model) {
    Require(size >= 0 && size <= (int64_t{1} << 30), "size = %d bytes; it must be 0 to 2^30", size);
    if (size > 0) RequirePointer("bytes", bytes);
    const auto* text = static_cast<const char*>(bytes);
    model.SetAnnotation(std::string(text, text + size));
  });
}

egosieve_status egosieve_gp_annotation(egosieve_gp* gp, void* bytes, int64_t capacity,
                                       int64_t* size) {
  return With(__func__, gp,
              [&](LearningModel& model) { GiveBytes(model.annotation(), bytes, capacity, size); });
}

egosieve_status egosieve_gp_save(egosieve_gp* gp, const char* path) {
  return With(__func__, gp, [&](LearningModel& model) {
    RequirePointer("path", path);
    Check(gp::WriteModelFile(path, model.ToFile()));
  });
}

egosieve_status egosieve_gp_load(const char* path, const char* device, egosieve_gp** gp) {
  return New(__func__, gp, [&] {
    RequirePointer("path", path);
    gp::ModelFile file = Take(gp::ReadModelFile(path));
    return LearningModel::Create(Take(ContextOf(device)), std::move(file));
  });
}

egosieve_status egosieve_gp_save_normalized(egosieve_gp* gp, const char* path) {
  return With(__func__, gp, [&](LearningModel& model) {
    RequirePointer("path", path);
    gp::ModelFile file = model.ToFile();
    file.is_normalized = true;
    Check(gp::WriteModelFile(path, file));
  });
}

egosieve_status egosieve_gp_load_normalized(const char* path, const char* device,
                                            egosieve_gp** gp) {
  return New(__func__, gp, [&] {
    RequirePointer("path", path);
    gp::ModelFile file = Take(gp::ReadModelFile(path, /*may_be_normalized=*/true));
    return LearningModel::Create(Take(ContextOf(device)), std::move(file));
  });
}

egosieve_status egosieve_gp_serialize(egosieve_gp* gp, void* bytes, int64_t capacity,
                                      int64_t* size) {
  return With(__func__, gp, [&](LearningModel& model) {
    GiveBytes(Take(gp::SerializeModel(model.ToFile())), bytes, capacity, size);
  });
}

egosieve_status egosieve_gp_deserialize(const void* bytes, int64_t size, const char* device,
                                        egosieve_gp** gp) {
  return New(__func__, gp, [&] {
    RequirePointer("bytes", bytes);
    Require(size >= 0, "size = %d is negative", size);
    const std::string_view text(static_cast<const char*>(bytes), static_cast<size_t>(size));
    gp::ModelFile file = Take(gp::ParseModel(text));
    return LearningModel::Create(Take(ContextOf(device)), std::move(file));
  });
}

}  // extern "C"

}  // namespace egosieve::embed
