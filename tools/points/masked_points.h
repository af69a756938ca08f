// Points of a sparse model that lie on what is masked.
//
//   seen     the point's observations in images that have a mask, within the picture      (DP1)
//   masked   those of them on a pixel that is masked                                      (DP2)
//   dropped  seen > 0 and 2 masked >= seen                                                (DP3)
//
// An observation (x, y) lies on pixel (floor x, floor y). A point that is seen in no mask stays.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "tools/colmap/sparse_model.h"

namespace egosieve::tools {

struct MaskedPoints {
  int64_t points = 0, dropped = 0;           // before; of them
  int64_t images = 0, images_with_mask = 0;  // of the model
};

// Removes the points of (DP3), and their ids from the observations. mask: of an image, 0 where
// masked; empty if it has none. The model is unchanged after an error: that of `mask`; DataLoss for
// an observation of a point that the model lacks; OutOfRange for a mask of another size than its
// camera.
absl::StatusOr<MaskedPoints> DropMaskedPoints(
    absl::FunctionRef<absl::StatusOr<cv::Mat1b>(const SparseImage&)> mask, SparseModel& model);

}  // namespace egosieve::tools
