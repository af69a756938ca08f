// Finds pieces of a numbered mover that do not belong to it.
//
//   apart    two pieces in different regions of the mask, so that static pixels and no other mover
//            are between them, whose boxes are farther apart than half the root of the smaller
//            one's area                                                                     (MP1)
//   stray    a piece that is apart from the largest piece of its number, or much smaller than it
//
// An object that occludes a mover and cuts it in two, such as a pole, is narrower than the parts.
#pragma once

#include <opencv2/core.hpp>

#include "vision/masks/regions.h"

namespace egosieve::vision {

// The connected regions of a mask.
class RegionLabels {
 public:
  RegionLabels() = default;  // no regions
  explicit RegionLabels(const cv::Mat1b& mask);

  // (MP1); the pieces must lie in the mask.
  bool LieApart(const Piece& a, const Piece& b) const;

 private:
  int LabelOf(const Piece& piece) const;

  cv::Mat1i labels_;
};

// Removes the numbers of stray pieces, and of pieces of fewer than half min_pixels. regions: of the
// mask in which the numbers lie.
void DropStrays(const RegionLabels& regions, int min_pixels, cv::Mat1w& numbers);

}  // namespace egosieve::vision
