// Cuts long drives into pieces that can be learnt on several machines (plan.h).
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVE_CUTS_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVE_CUTS_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

// The frames at which a drive of `frames` frames, `seconds_per_frame` apart, is cut into the fewest
// pieces of equal length that last at most `minutes`. Empty if one piece is enough.
std::vector<int64_t> EqualCuts(int64_t frames, double seconds_per_frame, double minutes);

// The same, but pieces end at scene cuts, and each holds as many scenes as last at most `minutes`
// together. A longer scene is cut into pieces of its own, of equal length. `scenes`: first frames
// of the further scenes, ascending.
std::vector<int64_t> CutsAtScenes(int64_t frames, const std::vector<int64_t>& scenes,
                                  double seconds_per_frame, double minutes);

struct CutOptions {
  double minutes = 0.0;  // largest length of a piece; 0: drives are not cut
  bool at_scenes = false;
};

// Gives cuts to drives without them, from the length in their headers and the time between their
// first two frames. For cuts at scenes, each drive is read once, and the scenes found are stored
// with the notes of its tasks (plan.h). Drives that cannot be read are not cut: their task reports
// the error. Cancelled if the process was asked to stop.
absl::Status CutDrives(const CutOptions& options, std::vector<BatchEntry>& entries);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVE_CUTS_H_
