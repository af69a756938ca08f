// The shots of a drive, in its run folder.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::tools {

// The shots of a drive (vision/labelling/shots.h).
struct ShotList {
  std::vector<int64_t> first_frames;  // 0 for the first shot; empty: not known
  int64_t end = -1;                   // they were looked for before this frame; -1: in all frames
};
// Of the run in `path`. DataLoss for a damaged file.
absl::StatusOr<ShotList> ReadShots(const std::string& path);
absl::Status WriteShots(const std::string& path, const ShotList& shots);
// "3 shots, cut before frames 12, 90"; empty for a single shot.
std::string DescribeCuts(const ShotList& shots);

}  // namespace egosieve::tools
