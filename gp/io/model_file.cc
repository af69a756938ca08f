#include "gp/io/model_file.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gp/io/array_file.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

constexpr int64_t kNamedFunction = 2;

int64_t NumberOf(CovarianceFunction function) {
  if (function == CovarianceFunction::kArcsine) return 0;
  return function == CovarianceFunction::kSquaredExponential ? 1 : kNamedFunction;
}

// Takes the array of this name and type out of the map. Arrays of rank 1 must have the size
// `want_size`; -1 takes any.
template <typename T>
absl::StatusOr<std::vector<T>> Take(const char* name, int64_t want_size, ArrayMap& arrays) {
  const auto found = arrays.find(name);
  EGOSIEVE_REQUIRE(DataLoss, found != arrays.end(), "the array %s is missing", name);
  auto* elements = std::get_if<std::vector<T>>(&found->second.elements);
  EGOSIEVE_REQUIRE(DataLoss, elements != nullptr, "the array %s has another type", name);
  EGOSIEVE_REQUIRE(DataLoss, want_size < 0 || static_cast<int64_t>(elements->size()) == want_size,
                   "the array %s has %d elements; it must have %d", name, elements->size(),
                   want_size);
  return std::move(*elements);
}

absl::Status CheckVersion(ArrayMap& arrays) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> version,
                            Take<int64_t>("format_version", 1, arrays));
  EGOSIEVE_REQUIRE(DataLoss, version[0] >= 1, "format version %d", version[0]);
  EGOSIEVE_REQUIRE(Unimplemented, version[0] <= kModelFormatVersion,
                   "format version %d; this program reads up to %d: use a newer one", version[0],
                   kModelFormatVersion);
  return absl::OkStatus();
}

absl::Status TakeFunction(ArrayMap& arrays, kernels::CovarianceParameters& covariance) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> function,
                            Take<int64_t>("covariance_function", 1, arrays));
  if (function[0] != kNamedFunction) {
    EGOSIEVE_REQUIRE(DataLoss, function[0] == 0 || function[0] == 1, "covariance function %d",
                     function[0]);
    covariance.function =
        function[0] == 0 ? CovarianceFunction::kArcsine : CovarianceFunction::kSquaredExponential;
    return absl::OkStatus();
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<uint8_t> name,
                            Take<uint8_t>("covariance_name", -1, arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(covariance.function,
                            CovarianceFunction::Parse(std::string(name.begin(), name.end())));
  const auto inputs = arrays.find("inputs");
  EGOSIEVE_REQUIRE(DataLoss, inputs != arrays.end() && inputs->second.shape.size() == 2,
                   "the array inputs is missing or has another shape");
  covariance.dimension = inputs->second.shape[1];
  return absl::OkStatus();
}

// y and the noise variances of the points, if any.
absl::Status TakeTargets(ArrayMap& arrays, PointSet& points) {
  const auto targets = arrays.find("targets");
  if (targets != arrays.end() && targets->second.shape.size() == 2) {
    points.outputs = targets->second.shape[1];
  }
  EGOSIEVE_ASSIGN_OR_RETURN(points.targets, Take<double>("targets", -1, arrays));
  if (arrays.find("noise_variances") == arrays.end()) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(points.noise_variances, Take<double>("noise_variances", -1, arrays));
  return absl::OkStatus();
}

absl::Status TakeMeanFunction(ArrayMap& arrays, MeanFunction& mean) {
  if (arrays.find("mean_function") == arrays.end()) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> number,
                            Take<int64_t>("mean_function", 1, arrays));
  EGOSIEVE_REQUIRE(DataLoss,
                   number[0] >= 0 && number[0] <= static_cast<int64_t>(MeanFunction::kLinear),
                   "mean function %d", number[0]);
  mean = static_cast<MeanFunction>(number[0]);
  return absl::OkStatus();
}

absl::Status TakeModel(ArrayMap& arrays, ExactModelState& model) {
  kernels::CovarianceParameters& covariance = model.hyperparameters.covariance;
  EGOSIEVE_RETURN_IF_ERROR(TakeFunction(arrays, covariance));
  EGOSIEVE_ASSIGN_OR_RETURN(covariance.scales, Take<double>("scales", -1, arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> signal_noise,
                            Take<double>("signal_noise", 2, arrays));
  covariance.signal_stddev = signal_noise[0];
  model.hyperparameters.noise_stddev = signal_noise[1];
  EGOSIEVE_RETURN_IF_ERROR(model.hyperparameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(TakeMeanFunction(arrays, model.hyperparameters.mean));
  EGOSIEVE_RETURN_IF_ERROR(TakeTargets(arrays, model.points));
  const int64_t n = static_cast<int64_t>(model.points.targets.size()) /
                    std::max<int64_t>(1, model.points.outputs);
  EGOSIEVE_ASSIGN_OR_RETURN(model.points.inputs,
                            Take<double>("inputs", n * covariance.input_dimension(), arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(model.points.identities, Take<int64_t>("identities", n, arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(model.points.insertion_times, Take<int64_t>("birth_frames", n, arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> next,
                            Take<int64_t>("next_identity", 1, arrays));
  model.points.next_identity = next[0];
  return model.Validate();
}

absl::Status TakeSparse(ArrayMap& arrays, std::optional<SparseModelOptions>& sparse) {
  if (arrays.find("sparse") == arrays.end()) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> numbers, Take<int64_t>("sparse", 2, arrays));
  EGOSIEVE_REQUIRE(DataLoss, numbers[0] == 1 || numbers[0] == 2, "sparse approximation %d",
                   numbers[0]);
  SparseModelOptions options;
  options.approximation = numbers[0] == 1 ? SparseApproximation::kDtc : SparseApproximation::kFitc;
  options.inducing_points = numbers[1];
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  sparse = options;
  return absl::OkStatus();
}

absl::Status TakeIterative(ArrayMap& arrays, int64_t targets,
                           std::optional<IterativeFile>& iterative) {
  if (arrays.find("iterative") == arrays.end()) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> numbers,
                            Take<double>("iterative", 2, arrays));
  EGOSIEVE_REQUIRE(DataLoss, numbers[0] >= 1.0 && numbers[0] <= 0x1p53,
                   "a preconditioner of rank %g", numbers[0]);
  IterativeFile file;
  file.options.rank = static_cast<int64_t>(numbers[0]);
  file.options.gradients.tolerance = numbers[1];
  EGOSIEVE_RETURN_IF_ERROR(file.options.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(file.alpha, Take<double>("alpha", targets, arrays));
  iterative = std::move(file);
  return absl::OkStatus();
}

absl::Status TakeTrainer(ArrayMap& arrays, std::optional<TrainerState>& trainer) {
  if (arrays.find("trainer_theta") == arrays.end()) return absl::OkStatus();
  TrainerState state;
  EGOSIEVE_ASSIGN_OR_RETURN(state.theta, Take<double>("trainer_theta", -1, arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(state.optimiser.steps, Take<double>("trainer_steps", -1, arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(state.optimiser.previous_gradient,
                            Take<double>("trainer_gradient", -1, arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> counts,
                            Take<int64_t>("trainer_counts", 2, arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> smoothed,
                            Take<double>("trainer_smoothed", 2, arrays));
  state.rounds = counts[0];
  state.rounds_since_step = counts[1];
  state.smoothed_movement = smoothed[0];
  if (std::isfinite(smoothed[1])) state.smoothed_objective = smoothed[1];
  trainer = std::move(state);
  return absl::OkStatus();
}

absl::Status CheckSquash(const SquashParameters& squash) {
  EGOSIEVE_REQUIRE(InvalidArgument,
                   squash.a > 0.0 && std::isfinite(squash.a) && std::isfinite(squash.b),
                   "squash a = %g, b = %g; a must be positive and both finite", squash.a, squash.b);
  return absl::OkStatus();
}

// Bytes of the machine.
double Memory() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

// The factor of an exact model of n points, n x n, or of an iterative model's preconditioner.
absl::Status CheckMemory(int64_t n, int64_t columns) {
  const double factor = 8.0 * static_cast<double>(n) * static_cast<double>(columns);
  const double memory = Memory();
  EGOSIEVE_REQUIRE(FailedPrecondition, factor <= memory,
                   "the factor of %d points takes %.0f GB; this machine has %.0f", n, 1e-9 * factor,
                   1e-9 * memory);
  return absl::OkStatus();
}

// What a sparse or an iterative model is.
absl::Status PutRepresentation(const ModelFile& file, ArrayMap& arrays) {
  if (file.sparse.has_value()) {
    EGOSIEVE_RETURN_IF_ERROR(file.sparse->Validate());
    arrays["sparse"] =
        VectorArray<int64_t>({file.sparse->approximation == SparseApproximation::kFitc ? 2 : 1,
                              file.sparse->inducing_points});
  }
  if (!file.iterative.has_value()) return absl::OkStatus();
  const IterativeModelOptions& options = file.iterative->options;
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  arrays["iterative"] =
      VectorArray<double>({static_cast<double>(options.rank), options.gradients.tolerance});
  arrays["alpha"] = VectorArray(file.iterative->alpha);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> SerializeModel(const ModelFile& file) {
  const ExactModelState& model = file.model;
  EGOSIEVE_RETURN_IF_ERROR(model.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckSquash(file.squash));
  const kernels::CovarianceParameters& covariance = model.hyperparameters.covariance;
  ArrayMap arrays;
  const bool plain = model.points.outputs == 1 && model.points.noise_variances.empty() &&
                     model.hyperparameters.mean == MeanFunction::kZero;
  arrays["format_version"] = VectorArray<int64_t>({file.is_normalized ? kModelFormatVersion
                                                   : file.iterative.has_value() ? 5
                                                   : file.is_laplace            ? 4
                                                   : file.sparse.has_value()    ? 3
                                                   : plain                      ? 1
                                                                                : 2});
  const int64_t number = NumberOf(covariance.function);
  arrays["covariance_function"] = VectorArray<int64_t>({number});
  if (number == kNamedFunction) {
    const std::string_view name = covariance.function.text();
    arrays["covariance_name"] = VectorArray(std::vector<uint8_t>(name.begin(), name.end()));
  }
  arrays["scales"] = VectorArray(covariance.scales);
  arrays["signal_noise"] =
      VectorArray<double>({covariance.signal_stddev, model.hyperparameters.noise_stddev});
  arrays["inputs"] = VectorArray(model.points.inputs);
  arrays["inputs"].shape = {model.points.size(), covariance.input_dimension()};
  arrays["targets"] = VectorArray(model.points.targets);
  if (model.points.outputs > 1) {
    arrays["targets"].shape = {model.points.size(), model.points.outputs};
  }
  if (!model.points.noise_variances.empty()) {
    arrays["noise_variances"] = VectorArray(model.points.noise_variances);
  }
  if (model.hyperparameters.mean != MeanFunction::kZero) {
    arrays["mean_function"] =
        VectorArray<int64_t>({static_cast<int64_t>(model.hyperparameters.mean)});
  }
  EGOSIEVE_RETURN_IF_ERROR(PutRepresentation(file, arrays));
  if (file.is_laplace) arrays["laplace"] = VectorArray<int64_t>({1});
  if (file.is_normalized) arrays["normalized"] = VectorArray<int64_t>({1});
  arrays["identities"] = VectorArray(model.points.identities);
  arrays["birth_frames"] = VectorArray(model.points.insertion_times);
  arrays["next_identity"] = VectorArray<int64_t>({model.points.next_identity});
  arrays["squash"] = VectorArray<double>({file.squash.a, file.squash.b});
  arrays["annotations"] =
      VectorArray(std::vector<uint8_t>(file.annotations.begin(), file.annotations.end()));
  if (file.trainer.has_value()) {
    const TrainerState& state = *file.trainer;
    arrays["trainer_theta"] = VectorArray(state.theta);
    arrays["trainer_steps"] = VectorArray(state.optimiser.steps);
    arrays["trainer_gradient"] = VectorArray(state.optimiser.previous_gradient);
    arrays["trainer_counts"] = VectorArray<int64_t>({state.rounds, state.rounds_since_step});
    arrays["trainer_smoothed"] = VectorArray<double>(
        {state.smoothed_movement, state.smoothed_objective.value_or(std::nan(""))});
  }
  return SerializeArrays(arrays);
}

absl::StatusOr<ModelFile> ParseModel(std::string_view bytes, bool may_be_normalized) {
  EGOSIEVE_ASSIGN_OR_RETURN(ArrayMap arrays, ParseArrays(bytes));
  EGOSIEVE_RETURN_IF_ERROR(CheckVersion(arrays));
  ModelFile file;
  EGOSIEVE_RETURN_IF_ERROR(TakeModel(arrays, file.model));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> squash, Take<double>("squash", 2, arrays));
  file.squash = {squash[0], squash[1]};
  EGOSIEVE_RETURN_IF_ERROR(CheckSquash(file.squash));
  EGOSIEVE_RETURN_IF_ERROR(TakeSparse(arrays, file.sparse));
  const int64_t n = file.model.points.size();
  EGOSIEVE_RETURN_IF_ERROR(TakeIterative(arrays, n * file.model.points.outputs, file.iterative));
  file.is_laplace = arrays.contains("laplace");
  file.is_normalized = arrays.contains("normalized");
  EGOSIEVE_REQUIRE(
      FailedPrecondition, !file.is_normalized || may_be_normalized,
      "its y are normalised, as by normalize_y in Python, whose egosieve.GaussianProcess.load "
      "reads it; C and C++ would predict in other units");
  if (!file.sparse.has_value()) {
    EGOSIEVE_RETURN_IF_ERROR(
        CheckMemory(n, file.iterative.has_value() ? std::min(n, file.iterative->options.rank) : n));
  }
  EGOSIEVE_RETURN_IF_ERROR(TakeTrainer(arrays, file.trainer));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<uint8_t> annotations,
                            Take<uint8_t>("annotations", -1, arrays));
  file.annotations.assign(annotations.begin(), annotations.end());
  return file;
}

absl::Status WriteModelFile(const std::string& path, const ModelFile& file) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes, SerializeModel(file));
  return kernels::WriteFileAtomically(path, bytes);
}

absl::StatusOr<ModelFile> ReadModelFile(const std::string& path, bool may_be_normalized) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes,
                            kernels::ReadFile(path, static_cast<int64_t>(0.25 * Memory())));
  absl::StatusOr<ModelFile> file = ParseModel(bytes, may_be_normalized);
  if (file.ok()) return file;
  return absl::Status(file.status().code(),
                      absl::StrCat(path, " is no readable model: ", file.status().message()));
}

}  // namespace egosieve::gp
