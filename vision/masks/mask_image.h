// From a refined map to a mask, and from numbers at working resolution to numbers per pixel.
//
//   mask    objects of the map (vision/objects/map_objects.h) by its thresholds: a pixel is moving
//           where p >= low and its region has a pixel with p >= high. All others, also unsure
//           ones, are static. Then the median of a square of 2 step + 1 pixels, step as in
//           edge_refinement.h, since the smoother there leaves streaks of one pixel         (I1)
//   number  of a pixel of the mask: that of the nearest numbered pixel at working resolution, at
//           most three of its pixels away; without one the pixel is removed from the mask    (I2)
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/objects/map_objects.h"

namespace egosieve::vision {

// (I1), 255 where moving, with holes of at most a 2000th of the picture's pixels filled. Pixels
// where `excluded` (the own vehicle) is not 0 are static whatever their probability. `excluded` has
// the map's size, or is empty.
cv::Mat1b MaskOf(const cv::Mat1f& probability, const ObjectThresholds& thresholds,
                 const cv::Mat1b& excluded);

// The mask at working resolution, sampled at the nearest pixels.
cv::Mat1b SmallMask(const cv::Mat1b& mask, cv::Size size);

// (I2). small: numbers at working resolution. mask: pixels without a number are set to 0.
cv::Mat1w NumberPixels(const cv::Mat1w& small, cv::Mat1b& mask);

}  // namespace egosieve::vision
