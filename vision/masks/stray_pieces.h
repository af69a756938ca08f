// Which pieces of a numbered mover are not its own.
//
//   apart    two pieces in different regions of the mask, so that static pixels and no other mover
//            lie between them, whose boxes are farther from each other than half the root of the
//            smaller one's area                                                           (MP1)
//   stray    a piece that is apart from the largest piece of its number, or much smaller than it
//
// What stands before a mover and cuts it in two, such as a pole, is narrower than the parts.
#ifndef EGOSIEVE_VISION_MASKS_STRAY_PIECES_H_
#define EGOSIEVE_VISION_MASKS_STRAY_PIECES_H_

#include <opencv2/core.hpp>

#include "vision/masks/regions.h"

namespace egosieve::vision {

// The connected regions of a mask.
class RegionLabels {
 public:
  RegionLabels() = default;  // none
  explicit RegionLabels(const cv::Mat1b& mask);

  // (MP1); the pieces lie in the mask.
  bool LieApart(const Piece& a, const Piece& b) const;

 private:
  int LabelOf(const Piece& piece) const;

  cv::Mat1i labels_;
};

// Takes their number from stray pieces, and from those of fewer than half min_pixels. regions: of
// the mask that the numbers lie in.
void DropStrays(const RegionLabels& regions, int min_pixels, cv::Mat1w& numbers);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MASKS_STRAY_PIECES_H_
