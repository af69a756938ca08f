#include "tools/batch/drive_cuts.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "vision/frame/frame_source.h"

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

// Of the next frame that can be read; none at the end.
std::optional<double> NextTime(vision::FrameSource& source) {
  while (true) {
    const absl::StatusOr<vision::FrameRead> read = source.Next();
    if (!read.ok() || std::holds_alternative<vision::EndOfFrames>(*read)) return std::nullopt;
    if (const auto* frame = std::get_if<vision::Frame>(&*read)) return frame->time_seconds;
  }
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

void CutDrives(double minutes, std::vector<BatchEntry>& entries) {
  for (BatchEntry& entry : entries) {
    if (!entry.cuts.empty()) continue;
    const absl::StatusOr<std::unique_ptr<vision::FrameSource>> source =
        vision::OpenFrameSource(entry.path, SourceOptions(entry.flags));
    if (!source.ok()) continue;
    const int64_t frames = (*source)->expected_frame_count();
    const std::optional<double> first = NextTime(**source), second = NextTime(**source);
    if (frames < 2 || !first || !second || !(*second > *first)) continue;
    entry.cuts = EqualCuts(frames, *second - *first, minutes);
  }
}

}  // namespace egosieve::tools
