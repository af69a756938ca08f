// Cuts long drives into pieces that can be learnt at the same time (plan.h).
#ifndef EGOSIEVE_TOOLS_BATCH_CUTS_H_
#define EGOSIEVE_TOOLS_BATCH_CUTS_H_

#include <cstdint>
#include <vector>

#include "tools/batch/manifest.h"

namespace egosieve::tools {

// The frames at which a drive of `frames` frames, `seconds_per_frame` apart, is cut into the fewest
// pieces of equal length that last at most `minutes`. Empty if one piece is enough.
std::vector<int64_t> EqualCuts(int64_t frames, double seconds_per_frame, double minutes);

// Gives cuts to drives without them, from the length in their headers and the time between their
// first two frames. Drives that cannot be read are not cut: their task reports the error.
void CutDrives(double minutes, std::vector<BatchEntry>& entries);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_CUTS_H_
