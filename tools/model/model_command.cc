#include "tools/model/model_command.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gp/io/model_file.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/interruption.h"
#include "tools/cli/result_flag.h"
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

class ModelCommand : public Command {
 public:
  std::string name() const override { return "model"; }
  std::string summary() const override {
    return "Prints what a checkpoint of the model holds; writes its points as CSV.";
  }
  std::string example() const override {
    return "egosieve model out/drive\negosieve model out/drive/model/000049.npz --csv=points.csv";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("FILE", path_, "A model file, or a run folder: its newest checkpoint")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--csv", csv_, "Write identity, birth frame, label and inputs of every point")
        ->type_name("FILE");
    app.add_flag("--overwrite", overwrite_, "Replace the file of --csv");
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EndOnInterruptions();
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string path, FindModelFile(path_));
    const absl::StatusOr<gp::ModelFile> file = gp::ReadModelFile(path);
    if (!file.ok()) {
      return absl::DataLossError(
          absl::StrCat(file.status().message(), "; give a file that segment wrote into model/"));
    }
    if (!csv_.empty()) {
      std::error_code error;
      if (!overwrite_ && fs::exists(fs::symlink_status(csv_, error))) {
        return absl::AlreadyExistsError(
            absl::StrCat(csv_, " is there already; name another file, or add --overwrite"));
      }
      if (fs::equivalent(csv_, path, error)) {
        return absl::InvalidArgumentError(
            absl::StrCat("--csv=", csv_, " is the model itself; name another file"));
      }
    }
    std::string text = Describe(path, *file);
    if (!csv_.empty()) {
      const absl::Status written = WriteFileAtomically(csv_, PointsAsCsv(file->model));
      if (absl::IsNotFound(written)) return AsUsageError(written);  // the folder is missing
      EGOSIEVE_RETURN_IF_ERROR(written);
      absl::StrAppend(&text, "points in ", csv_, "\n");
    }
    result_.Tell(name(), ToJson(path, *file), text);
    return ExitCode::kDone;
  }

 private:
  std::string path_, csv_;
  bool overwrite_ = false;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeModelCommand() { return std::make_unique<ModelCommand>(); }

}  // namespace egosieve::tools
