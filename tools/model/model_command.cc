#include "tools/model/model_command.h"

#include <string>

#include "tools/model/model_run.h"

namespace egosieve::tools {
namespace {

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
    app.add_option("FILE", options_.path, "A model file, or a run folder: its newest checkpoint")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--csv", options_.csv,
                   "Write identity, birth frame, label and inputs of every point")
        ->type_name("FILE");
    app.add_flag("--overwrite", options_.overwrite, "Replace the file of --csv");
    options_.result.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override { return RunModel(options_); }

 private:
  ModelOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeModelCommand() { return std::make_unique<ModelCommand>(); }

}  // namespace egosieve::tools
