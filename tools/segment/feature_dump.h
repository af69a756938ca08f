// Writes what a frame's map is learnt from and evaluated on, for classifiers outside the program
// (tools/evaluate/compare.py).
#ifndef EGOSIEVE_TOOLS_SEGMENT_FEATURE_DUMP_H_
#define EGOSIEVE_TOOLS_SEGMENT_FEATURE_DUMP_H_

#include <string>

#include "absl/status/status.h"
#include "kernels/runtime/context.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {

// Writes DIRECTORY/NNNNNN.npz for a frame with a picture; nothing for a damaged one. The directory
// exists. For N labelled places and the G pixels of the map's grid, row by row:
//
//   frames     4      indices of this frame, of the labelled one and of the pair's two; -1: none
//   grid       3      width and height of the picture and stride of the grid, pixels
//   labels     N      probability of moving, in [0, 1]
//   inputs     N x 6  descriptors of the labelled places (vision/descriptor)
//   field      G x 6  descriptors of the grid in this frame
//   positions  N x 2  places in the labelled frame, pixels
//   others     N x 2  the same places in the pair's other frame
//   kind       1      of motion: 0 none, 1 static, 2 homography, 3 fundamental matrix
absl::Status DumpFeatures(const vision::SegmentedFrame& frame, kernels::Context& context,
                          const vision::OnlineSegmenterOptions& options,
                          const std::string& directory);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_FEATURE_DUMP_H_
