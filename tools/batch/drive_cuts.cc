#include "tools/batch/drive_cuts.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>

#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/drive_files.h"
#include "tools/cli/interruption.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/atomic_file.h"
#include "vision/frame/frame_source.h"
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

// The time of the next frame that can be read; absent at the end.
std::optional<double> NextTime(vision::FrameSource& source) {
  while (true) {
    const absl::StatusOr<vision::FrameRead> read = source.Next();
    if (!read.ok() || std::holds_alternative<vision::EndOfFrames>(*read)) return std::nullopt;
    if (const auto* frame = std::get_if<vision::Frame>(&*read)) return frame->time_seconds;
  }
}

using Json = nlohmann::ordered_json;

// Identifies an input; differs if a file of the input has another size.
std::string Identity(const vision::FrameSource& source) {
  uintmax_t bytes = 0;
  for (const std::string& file : source.files()) {
    std::error_code error;
    const uintmax_t size = std::filesystem::file_size(file, error);
    if (!error) bytes += size;
  }
  return absl::StrCat(source.description(), ", ", bytes, " bytes");
}

// The scenes that an earlier call found in this input.
std::optional<vision::SceneCuts> ReadScenes(const std::string& path, const std::string& input) {
  const Json document = Json::parse(ReadFile(path).value_or(""), nullptr, false);
  if (!document.is_object() || document.value("input", Json()) != input) return std::nullopt;
  try {
    return vision::SceneCuts{document.at("frames").get<int64_t>(),
                             document.at("cuts").get<std::vector<int64_t>>()};
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

// If notes cannot be written, the next call only takes longer.
absl::StatusOr<vision::SceneCuts> ScenesOf(const BatchEntry& entry, vision::FrameSource& source) {
  const std::string path = TaskNotesPath(entry) + "/scenes.json";
  const std::string input = Identity(source);
  if (std::optional<vision::SceneCuts> known = ReadScenes(path, input)) return *std::move(known);
  std::cerr << absl::StrCat("batch: looking for scene cuts in ", entry.path, "\n");
  EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(0));
  EGOSIEVE_ASSIGN_OR_RETURN(vision::SceneCuts found,
                            vision::FindSceneCuts(source, [] { return !InterruptionRequested(); }));
  const Json document = {{"input", input}, {"frames", found.frames}, {"cuts", found.cuts}};
  absl::Status noted = CreateFolder(TaskNotesPath(entry));
  if (noted.ok()) noted = WriteFileAtomically(path, document.dump() + "\n");
  if (!noted.ok()) Warn(noted.message());
  return found;
}

absl::Status CutDrive(const CutOptions& options, BatchEntry& entry) {
  const absl::StatusOr<std::unique_ptr<vision::FrameSource>> source =
      vision::OpenFrameSource(entry.path, SourceOptions(entry.flags));
  if (!source.ok()) return absl::OkStatus();
  const int64_t frames = (*source)->expected_frame_count();
  const std::optional<double> first = NextTime(**source), second = NextTime(**source);
  if (!first || !second || !(*second > *first)) return absl::OkStatus();
  const double seconds_per_frame = *second - *first;
  if (!options.at_scenes) {
    if (frames > 1) entry.cuts = EqualCuts(frames, seconds_per_frame, options.minutes);
    return absl::OkStatus();
  }
  const absl::StatusOr<vision::SceneCuts> scenes = ScenesOf(entry, **source);
  if (absl::IsCancelled(scenes.status())) return scenes.status();
  if (!scenes.ok()) return absl::OkStatus();
  entry.cuts = CutsAtScenes(scenes->frames, scenes->cuts, seconds_per_frame, options.minutes);
  return absl::OkStatus();
}

}  // namespace

std::vector<int64_t> EqualCuts(int64_t frames, double seconds_per_frame, double minutes) {
  const double length = static_cast<double>(frames) * seconds_per_frame;
  const int64_t pieces =
      std::min(frames, static_cast<int64_t>(std::ceil(length / (60.0 * minutes))));
  std::vector<int64_t> cuts;
  for (int64_t piece = 1; piece < pieces; ++piece) cuts.push_back(piece * frames / pieces);
  return cuts;
}

std::vector<int64_t> CutsAtScenes(int64_t frames, const std::vector<int64_t>& scenes,
                                  double seconds_per_frame, double minutes) {
  std::vector<int64_t> cuts, ends = scenes;
  ends.push_back(frames);
  int64_t piece = 0, scene = 0;  // their first frames
  for (const int64_t end : ends) {
    if (!EqualCuts(end - piece, seconds_per_frame, minutes).empty()) {
      if (scene > piece) cuts.push_back(piece = scene);
      for (const int64_t cut : EqualCuts(end - scene, seconds_per_frame, minutes)) {
        cuts.push_back(piece = scene + cut);
      }
    }
    scene = end;
  }
  return cuts;
}

absl::Status CutDrives(const CutOptions& options, std::vector<BatchEntry>& entries) {
  if (!(options.minutes > 0.0)) return absl::OkStatus();
  for (BatchEntry& entry : entries) {
    if (entry.cuts.empty()) EGOSIEVE_RETURN_IF_ERROR(CutDrive(options, entry));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::tools
