#include "tools/masks/masks_command.h"

#include <string>

#include "tools/masks/masks_flags.h"
#include "tools/masks/masks_run.h"

namespace egosieve::tools {
namespace {

class MasksCommand : public Command {
 public:
  std::string name() const override { return "masks"; }
  std::string summary() const override {
    return "Writes masks of what moves as COLMAP, nerfstudio and others read them.";
  }
  std::string example() const override {
    return "egosieve masks images --for=colmap --dilate=10 --out=out/masks\n"
           "egosieve masks data/images --for=nerfstudio --dilate=10 --out=out/data\n"
           "egosieve masks my.mp4 --for=colmap --out=out/masks --frames=out/images\n"
           "egosieve masks images --from_video=my.mp4 --for=colmap --out=out/masks\n"
           "egosieve masks out/masks.run --for=coco --out=out/coco";
  }
  void AddFlags(CLI::App& app) override { flags_.AddFlags(app); }
  absl::StatusOr<ExitCode> Run() override { return RunMasks(flags_); }

 private:
  MasksFlags flags_;
};

}  // namespace

std::unique_ptr<Command> MakeMasksCommand() { return std::make_unique<MasksCommand>(); }

}  // namespace egosieve::tools
