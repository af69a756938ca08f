// Where long drives are cut, so that their pieces are learnt on several machines (plan.h).
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVE_CUTS_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVE_CUTS_H_

#include <cstdint>
#include <vector>

#include "tools/batch/manifest.h"

namespace egosieve::tools {

// The frames at which `frames` of them, `seconds_per_frame` apart, are cut into the fewest pieces
// of equal length that last `minutes` at most. Nothing where one piece does.
std::vector<int64_t> EqualCuts(int64_t frames, double seconds_per_frame, double minutes);

// Gives cuts to drives that have none, by the length in their headers and the time between their
// first two frames. Drives that cannot be read stay whole: their task says what is wrong.
void CutDrives(double minutes, std::vector<BatchEntry>& entries);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVE_CUTS_H_
