#include "tools/batch/cuts.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "tools/segment/drive_input.h"

namespace egosieve::tools {

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
    vision::FrameSourceOptions options;
    for (absl::string_view flag : entry.flags) {
      double rate = 0.0;
      if (absl::ConsumePrefix(&flag, "--times=")) options.times = std::string(flag);
      if (absl::ConsumePrefix(&flag, "--fps=") && absl::SimpleAtod(flag, &rate) && rate > 0) {
        options.nominal_rate_hz = rate;
      }
    }
    const absl::StatusOr<DriveInput> input = OpenDriveInput(entry.path, 0, options);
    if (!input.ok()) continue;
    const double seconds = SecondsPerFrame(*input->frames, 0).value_or(0.0);
    if (!(seconds > 0.0)) continue;
    entry.cuts = EqualCuts(input->frames->expected_frame_count(), seconds, minutes);
  }
}

}  // namespace egosieve::tools
