// Where long drives are cut, so that their pieces are learnt on several machines (plan.h).
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVE_CUTS_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVE_CUTS_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

// The frames at which `frames` of them, `seconds_per_frame` apart, are cut into the fewest pieces
// of equal length that last `minutes` at most. Nothing where one piece does.
std::vector<int64_t> EqualCuts(int64_t frames, double seconds_per_frame, double minutes);

// Likewise, but a piece ends where a scene does: with as many scenes as last `minutes` together.
// One that lasts longer is cut into pieces of its own, of equal length. `scenes`: the frames that
// begin another one, ascending.
std::vector<int64_t> CutsAtScenes(int64_t frames, const std::vector<int64_t>& scenes,
                                  double seconds_per_frame, double minutes);

struct CutOptions {
  double minutes = 0.0;  // of a piece at most; 0: drives stay as they are
  bool at_scenes = false;
};

// Gives cuts to drives that have none, by the length in their headers and the time between their
// first two frames. For cuts at scenes a drive is read once: what was found is kept with the notes
// of its tasks (plan.h). Drives that cannot be read stay whole: their task says what is wrong.
// Cancelled where the process was asked to stop.
absl::Status CutDrives(const CutOptions& options, std::vector<BatchEntry>& entries);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVE_CUTS_H_
