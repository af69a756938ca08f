#include "tools/reconstruct/reconstruct_command.h"

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/interruption.h"
#include "tools/cli/object_flags.h"
#include "tools/cli/progress.h"
#include "tools/cli/warning.h"
#include "tools/reconstruct/full_maps.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/run_folder.h"
#include "vision/objects/map_objects.h"

namespace egosieve::tools {
namespace {

absl::Status WriteMap(const std::string& path, const cv::Mat1f& values, double full_scale) {
  EGOSIEVE_ASSIGN_OR_RETURN(const EncodedMap encoded, EncodeMap(values, full_scale));
  return WriteFileAtomically(path, encoded.png);
}

// Boxes are [left, top, width, height] in pixels.
std::string ObjectsToText(const std::vector<vision::MapObject>& objects) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const vision::MapObject& object : objects) {
    list.push_back({{"box", {object.box.x, object.box.y, object.box.width, object.box.height}},
                    {"pixels", object.pixels},
                    {"peak_probability", object.peak},
                    {"mean_probability", object.mean},
                    {"mean_deviation", object.deviation}});
  }
  return list.dump(1) + "\n";
}

absl::Status ReconstructFrame(kernels::Context& context, const RunFolder& folder,
                              const RunDescription& description, const FrameLine& line,
                              const ClassThresholds& thresholds,
                              const vision::ObjectThresholds& objects) {
  const kernels::ImageGrid grid = GridOf(line, description);
  // Methods other than the process may have no deviation.
  const bool with_deviation =
      std::filesystem::exists(folder.FrameFile("grid", line.index, ".std.png"));
  EGOSIEVE_ASSIGN_OR_RETURN(const FrameMaps maps,
                            folder.ReadGridMaps(line, description, with_deviation));
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1f probability,
                            InterpolateMap(context, grid, maps.probability));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string classes,
                            EncodePng(ClassifyMap(probability, thresholds)));
  cv::Mat1f deviation;
  if (with_deviation) {
    EGOSIEVE_ASSIGN_OR_RETURN(deviation, InterpolateMap(context, grid, maps.deviation));
    EGOSIEVE_RETURN_IF_ERROR(WriteMap(folder.FrameFile("full", line.index, ".std.png"), deviation,
                                      description.deviation_full_scale));
  }
  EGOSIEVE_RETURN_IF_ERROR(
      WriteMap(folder.FrameFile("full", line.index, ".prob.png"), probability, 1.0));
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically(folder.FrameFile("full", line.index, ".class.png"), classes));
  return WriteFileAtomically(folder.FrameFile("full", line.index, ".objects.json"),
                             ObjectsToText(vision::FindObjects(probability, deviation, objects)));
}

class ReconstructCommand : public Command {
 public:
  std::string name() const override { return "reconstruct"; }
  std::string summary() const override {
    return "Writes maps of every pixel, three-class masks and lists of objects from a run's grid "
           "maps.";
  }
  std::string example() const override {
    return "egosieve reconstruct out/drive --dynamic_above=0.8";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", directory_, "The run folder; its full/ is written")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--static_below", thresholds_.static_below,
                   "Probability of moving below which a pixel's class is static (0)")
        ->type_name("P");
    app.add_option("--dynamic_above", thresholds_.dynamic_above,
                   "Probability of moving above which a pixel's class is dynamic (255)")
        ->type_name("P");
    AddObjectFlags(app, objects_);
    range_.AddFlags(app);
    device_.AddFlag(app);
    progress_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_RETURN_IF_ERROR(thresholds_.Validate());
    EGOSIEVE_RETURN_IF_ERROR(objects_.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(directory_));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, ChooseLines(folder, range_));
    EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder, description, lines));
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("full")));
    Progress progress("reconstruct", progress_, static_cast<int64_t>(lines.size()));
    int64_t frames = 0, unreadable = 0;
    for (const FrameLine& line : lines) {
      if (InterruptionRequested()) {
        return absl::CancelledError(absl::StrCat("interrupted after ", frames, " frames"));
      }
      if (line.has_map()) {
        EGOSIEVE_RETURN_IF_ERROR(
            ReconstructFrame(*device.context, folder, description, line, thresholds_, objects_));
        ++frames;
      } else {
        unreadable += line.outcome == FrameLine::Outcome::kFailed;
      }
      progress.Advance();
    }
    progress.Finish();
    std::cout << absl::StrFormat("%d frames reconstructed in %s\n", frames, folder.File("full"));
    Warn(DescribeMissingMaps(folder, description, lines));
    if (unreadable > 0) {
      Warn(absl::StrCat(unreadable, " frames could not be read and have no map"));
    }
    return unreadable > 0 ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

 private:
  std::string directory_;
  ClassThresholds thresholds_;
  vision::ObjectThresholds objects_;
  FrameRange range_;
  DeviceFlag device_;
  ProgressFlag progress_;
};

}  // namespace

std::unique_ptr<Command> MakeReconstructCommand() { return std::make_unique<ReconstructCommand>(); }

}  // namespace egosieve::tools
