// From a refined map to a mask, and from numbers at working resolution to numbers of every pixel.
//
//   mask    objects of the map (vision/objects/map_objects.h) by its thresholds: a pixel is moving
//           where p >= low and its region holds a pixel with p >= high. All others, the unsure
//           ones among them, are static. Then the median of a square of 2 step + 1 pixels, step as
//           in edge_refinement.h: the smoother there leaves streaks a pixel wide            (I1)
//   number  of a pixel of the mask: that of the nearest numbered pixel of working resolution, at
//           most three of its pixels away; without one the pixel is taken out of the mask    (I2)
#ifndef EGOSIEVE_VISION_MASKS_MASK_IMAGE_H_
#define EGOSIEVE_VISION_MASKS_MASK_IMAGE_H_

#include <opencv2/core.hpp>
#include <vector>

#include "vision/objects/map_objects.h"

namespace egosieve::vision {

// (I1), 255 where moving, after holes of fewer than a 2000th of the picture's pixels have been
// filled. Where `excluded` (the own vehicle) is not 0 it is static whatever the map says; that is
// of the map's size, or empty.
cv::Mat1b MaskOf(const cv::Mat1f& probability, const ObjectThresholds& thresholds,
                 const cv::Mat1b& excluded);

// The mask at working resolution: its nearest pixels.
cv::Mat1b SmallMask(const cv::Mat1b& mask, cv::Size size);

// (I2). small: numbers at working resolution. mask: changed where there is no number.
cv::Mat1w NumberPixels(const cv::Mat1w& small, cv::Mat1b& mask);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MASKS_MASK_IMAGE_H_
