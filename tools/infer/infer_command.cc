#include "tools/infer/infer_command.h"

#include <string>

#include "tools/infer/infer_flags.h"
#include "tools/infer/infer_run.h"

namespace egosieve::tools {
namespace {

class InferCommand : public Command {
 public:
  std::string name() const override { return "infer"; }
  std::string summary() const override {
    return "Makes the maps that segment --learn_only or --every left out.";
  }
  std::string example() const override {
    return "egosieve infer out/drive\n"
           "egosieve infer out/drive --from=1000 --to=1999 --device=gpu\n"
           "egosieve infer out/drive --stride=1 --every=10 --out=out/fine";
  }
  void AddFlags(CLI::App& app) override { flags_.AddFlags(app); }
  absl::StatusOr<ExitCode> Run() override { return RunInfer(flags_); }

 private:
  InferFlags flags_;
};

}  // namespace

std::unique_ptr<Command> MakeInferCommand() { return std::make_unique<InferCommand>(); }

}  // namespace egosieve::tools
