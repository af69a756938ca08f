// Labels on reduced pictures: their number, and what finding them costs, fall with the area.
//
//   s = min(1, longest side asked for / longer side of the picture)
//   x_full = (x + 1/2) / s - 1/2                                                           (RL1)
//
// With A the matrix of (RL1), a homography becomes A H A^-1 and a fundamental matrix A^-T F A^-1.
#ifndef EGOSIEVE_VISION_LABELLING_REDUCED_LABELS_H_
#define EGOSIEVE_VISION_LABELLING_REDUCED_LABELS_H_

#include <opencv2/core.hpp>

#include "vision/geometry/point_pair.h"
#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

// 0 reduces nothing.
cv::Size ReducedSize(cv::Size full, int longest_side_pixels);

// By averaging over areas; the picture itself where there is nothing to reduce.
cv::Mat ReducePicture(const cv::Mat& picture, int longest_side_pixels);
// A mask's nearest pixels.
cv::Mat1b ReduceMask(const cv::Mat1b& mask, int longest_side_pixels);

// (RL1) of both places.
PointPair EnlargePair(const PointPair& pair, cv::Size reduced, cv::Size full);

// Everything in pixels, from pictures of the size `reduced` to those of the size `full`.
void EnlargeLabels(cv::Size reduced, cv::Size full, LabelledFrame& labels);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_REDUCED_LABELS_H_
