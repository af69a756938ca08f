// Labels on reduced pictures: their number and the cost of finding them fall with the area.
//
//   s = min(1, longest side asked for / longer side of the picture)
//   x_full = (x + 1/2) / s - 1/2                                                           (RL1)
//
// With A the matrix of (RL1), a homography H becomes A H A^-1, a fundamental matrix F A^-T F A^-1.
#pragma once

#include <opencv2/core.hpp>

#include "vision/geometry/point_pair.h"
#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

// longest_side_pixels = 0: not reduced.
cv::Size ReducedSize(cv::Size full, int longest_side_pixels);

// Averages over areas; returns the picture itself if it is small enough.
cv::Mat ReducePicture(const cv::Mat& picture, int longest_side_pixels);
// Takes the nearest pixels.
cv::Mat1b ReduceMask(const cv::Mat1b& mask, int longest_side_pixels);

// Applies (RL1) to both places.
PointPair EnlargePair(const PointPair& pair, cv::Size reduced, cv::Size full);

// Converts all values in pixels from pictures of the size `reduced` to the size `full`.
void EnlargeLabels(cv::Size reduced, cv::Size full, LabelledFrame& labels);

}  // namespace egosieve::vision
