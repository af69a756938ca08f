// The scored maps of a run, frame by frame, as every form of truth needs them.
#ifndef EGOSIEVE_TOOLS_EVALUATE_SCORED_MAPS_H_
#define EGOSIEVE_TOOLS_EVALUATE_SCORED_MAPS_H_

#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/image_grid.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// The maps of grid/, as written, or every pixel of full/.
enum class ScoredPixels { kGrid, kFull };

// The deviation is left empty if the run has none. FailedPrecondition if full/ is requested and the
// frame has no map there.
absl::StatusOr<FrameMaps> ReadScoredMaps(const RunFolder& folder, const RunDescription& description,
                                         const FrameLine& line, ScoredPixels pixels);

// The pixels of the image at which those maps are given.
kernels::ImageGrid ScoredGrid(const FrameLine& line, const RunDescription& description,
                              ScoredPixels pixels);

struct ScorableLine {
  FrameLine line;
  bool of_prior = false;  // before anything was learnt: the map is the same everywhere
};

// The run's lines with a map. A method without a model learns only from the frame itself.
absl::StatusOr<std::vector<ScorableLine>> ReadScorableLines(const RunFolder& folder);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_SCORED_MAPS_H_
