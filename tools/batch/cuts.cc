#include "tools/batch/cuts.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/interruption.h"
#include "tools/segment/drive_input.h"
#include "vision/matching/scene_cuts.h"

namespace egosieve::tools {
namespace {

vision::FrameSourceOptions SourceOptions(const std::vector<std::string>& flags) {
  vision::FrameSourceOptions options;
  for (absl::string_view flag : flags) {
    double rate = 0.0;
    if (absl::ConsumePrefix(&flag, "--times=")) options.times = std::string(flag);
    if (absl::ConsumePrefix(&flag, "--fps=") && absl::SimpleAtod(flag, &rate) && rate > 0) {
      options.nominal_rate_hz = rate;
    }
  }
  return options;
}

absl::Status CutDrive(double minutes, bool at_scenes, BatchEntry& entry) {
  EGOSIEVE_ASSIGN_OR_RETURN(const DriveInput input,
                            OpenDriveInput(entry.path, 0, SourceOptions(entry.flags)));
  EGOSIEVE_ASSIGN_OR_RETURN(const double seconds, SecondsPerFrame(*input.frames, 0));
  if (!(seconds > 0.0)) return absl::OkStatus();
  vision::SceneCuts found = {input.frames->expected_frame_count(), {}};
  if (at_scenes) {
    std::cerr << absl::StrCat("batch: looking for scene cuts in ", entry.path, "\n");
    EGOSIEVE_RETURN_IF_ERROR(input.frames->SeekTo(0));
    EGOSIEVE_ASSIGN_OR_RETURN(found, vision::FindSceneCuts(*input.frames, [] {
                                return !InterruptionRequested();
                              }));
  }
  entry.cuts = CutsOf(found.frames, found.cuts, 60.0 * minutes / seconds);
  return absl::OkStatus();
}

}  // namespace

std::vector<int64_t> CutsOf(int64_t frames, const std::vector<int64_t>& scenes, double longest) {
  const auto pieces_of = [&](int64_t length) {
    return std::min(length, static_cast<int64_t>(std::ceil(static_cast<double>(length) / longest)));
  };
  std::vector<int64_t> cuts, ends = scenes;
  ends.push_back(frames);
  int64_t piece = 0, scene = 0;  // their first frames
  for (const int64_t end : ends) {
    if (pieces_of(end - piece) > 1) {
      if (scene > piece) cuts.push_back(piece = scene);
      const int64_t pieces = pieces_of(end - scene);
      for (int64_t i = 1; i < pieces; ++i) {
        cuts.push_back(piece = scene + i * (end - scene) / pieces);
      }
    }
    scene = end;
  }
  return cuts;
}

absl::Status CutDrives(double minutes, bool at_scenes, std::vector<BatchEntry>& entries) {
  for (BatchEntry& entry : entries) {
    const absl::Status status =
        minutes > 0.0 && entry.cuts.empty() ? CutDrive(minutes, at_scenes, entry) : absl::OkStatus();
    if (absl::IsCancelled(status)) return status;
  }
  return absl::OkStatus();
}

}  // namespace egosieve::tools
