// Cuts long drives into pieces that can be learnt on several machines (plan.h).
#ifndef EGOSIEVE_TOOLS_BATCH_CUTS_H_
#define EGOSIEVE_TOOLS_BATCH_CUTS_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

// The frames at which a drive is cut into pieces of at most `longest` frames. A piece ends at a
// scene cut and holds as many scenes as fit; a scene that does not fit is cut into the fewest
// pieces of equal length. `scenes`: first frames of the further scenes, ascending; where there are
// none, the drive is one scene. Empty if one piece is enough.
std::vector<int64_t> CutsOf(int64_t frames, const std::vector<int64_t>& scenes, double longest);

// Gives cuts to drives without them, in pieces of at most `minutes`, from the length in their
// headers and the time between their first two frames; at scenes, from reading each drive to its
// end. Drives that cannot be read are not cut: their task reports the error. Cancelled if the
// process was asked to stop.
absl::Status CutDrives(double minutes, bool at_scenes, std::vector<BatchEntry>& entries);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_CUTS_H_
