#include "tools/model/model_run.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gp/io/model_file.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/interruption.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// The file itself, or the newest checkpoint of a run folder.
absl::StatusOr<std::string> FindModelFile(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return path;
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(path) / "model", error)) {
    if (entry.path().extension() == ".npz") files.push_back(entry.path().string());
  }
  if (files.empty()) {
    return absl::NotFoundError(absl::StrCat(
        path, " holds no checkpoint in model/; give a run of more frames than --checkpoint_every"));
  }
  return *std::max_element(files.begin(), files.end());
}

int64_t DynamicPoints(const gp::ExactModelState& model) {
  return std::count_if(model.points.targets.begin(), model.points.targets.end(),
                       [](double target) { return target >= 0.0; });
}

std::string Describe(const std::string& path, const gp::ModelFile& file) {
  const gp::ExactModelState& model = file.model;
  const auto& covariance = model.hyperparameters.covariance;
  const int64_t dynamic = DynamicPoints(model);
  const int64_t size = model.points.size();
  std::string text = absl::StrFormat("%s\n", path);
  absl::StrAppendFormat(&text, "points       %d: %d dynamic, %d static\n", size, dynamic,
                        size - dynamic);
  if (size > 0) {
    const auto [oldest, newest] = std::minmax_element(model.points.insertion_times.begin(),
                                                      model.points.insertion_times.end());
    absl::StrAppendFormat(&text, "born         in frames %d to %d\n", *oldest, *newest);
  }
  absl::StrAppendFormat(&text, "covariance   %s of %d inputs\n",
                        std::string(covariance.function.text()), covariance.input_dimension());
  absl::StrAppend(&text, "scales      ");
  for (const double scale : covariance.scales) absl::StrAppendFormat(&text, " %.4g", scale);
  absl::StrAppendFormat(&text, "\nsigma        f %.4g, n %.4g\n", covariance.signal_stddev,
                        model.hyperparameters.noise_stddev);
  absl::StrAppendFormat(&text, "calibration  a %.4g, b %.4g\n", file.squash.a, file.squash.b);
  if (file.trainer) {
    absl::StrAppendFormat(&text, "trained on   %d frames\n", file.trainer->rounds);
  }
  return text;
}

nlohmann::ordered_json ToJson(const std::string& path, const gp::ModelFile& file) {
  const gp::Hyperparameters& hyperparameters = file.model.hyperparameters;
  return {{"file", path},
          {"points", file.model.points.targets.size()},
          {"dynamic_points", DynamicPoints(file.model)},
          {"covariance", std::string(hyperparameters.covariance.function.text())},
          {"scales", hyperparameters.covariance.scales},
          {"signal_stddev", hyperparameters.covariance.signal_stddev},
          {"noise_stddev", hyperparameters.noise_stddev},
          {"calibration_a", file.squash.a},
          {"calibration_b", file.squash.b}};
}

std::string PointsAsCsv(const gp::ExactModelState& model) {
  const int64_t dimension = model.hyperparameters.covariance.input_dimension();
  std::string csv = "identity,birth_frame,label";
  for (int64_t d = 0; d < dimension; ++d) absl::StrAppend(&csv, ",x", d);
  absl::StrAppend(&csv, "\n");
  for (size_t i = 0; i < model.points.targets.size(); ++i) {
    absl::StrAppendFormat(&csv, "%d,%d,%.6g", model.points.identities[i],
                          model.points.insertion_times[i], 0.5 * (model.points.targets[i] + 1.0));
    for (int64_t d = 0; d < dimension; ++d) {
      absl::StrAppendFormat(&csv, ",%.9g", model.points.inputs[i * dimension + d]);
    }
    absl::StrAppend(&csv, "\n");
  }
  return csv;
}

}  // namespace

absl::StatusOr<ExitCode> RunModel(const ModelOptions& options) {
  EndOnInterruptions();
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string path, FindModelFile(options.path));
  const absl::StatusOr<gp::ModelFile> file = gp::ReadModelFile(path);
  if (!file.ok()) {
    return absl::DataLossError(
        absl::StrCat(file.status().message(), "; give a file that segment wrote into model/"));
  }
  if (!options.csv.empty()) {
    std::error_code error;
    if (!options.overwrite && fs::exists(fs::symlink_status(options.csv, error))) {
      return absl::AlreadyExistsError(
          absl::StrCat(options.csv, " is there already; name another file, or add --overwrite"));
    }
    if (fs::equivalent(options.csv, path, error)) {
      return absl::InvalidArgumentError(
          absl::StrCat("--csv=", options.csv, " is the model itself; name another file"));
    }
  }
  std::string text = Describe(path, *file);
  if (!options.csv.empty()) {
    const absl::Status written = WriteFileAtomically(options.csv, PointsAsCsv(file->model));
    if (absl::IsNotFound(written)) return AsUsageError(written);  // the folder is missing
    EGOSIEVE_RETURN_IF_ERROR(written);
    absl::StrAppend(&text, "points in ", options.csv, "\n");
  }
  options.result.Tell("model", ToJson(path, *file), text);
  return ExitCode::kDone;
}

}  // namespace egosieve::tools
