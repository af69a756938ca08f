// Brings a map to a picture's full resolution, with its steps at the edges of the picture.
//
//   l(x)   log odds (SS3) of shot_segmentation.h, at working resolution                       (ER1)
//   p      = fgs(1 / (1 + exp(-l))), l interpolated linearly to full resolution               (ER2)
//            kept within 0.002 and 0.998
//   fgs    argmin_p sum (p - p_0)^2 + r^2 sum_{x ~ y} exp(-|I_x - I_y| / c) (p_x - p_y)^2: by the
//          fast global smoother; r = kEdgeReach times the longer side, in pixels; c =
//          kEdgeLevels over the picture's gain (tonal_range.h)
//
// It solves this along rows and along columns, with r, r / 2 and r / 4. Without edges the influence
// of a pixel falls by about the factor e over r, the same share of the picture at every resolution.
//
// (ER2) smooths probabilities, not log odds. So p stays near 1/2 where map and colour are unsure,
// and sure regions do not spread across edges.
//
// Reference: Min, Choi, Lu, Ham, Sohn & Do, Fast global image smoothing based on weighted least
// squares (2014).
#pragma once

#include <opencv2/core.hpp>

namespace egosieve::vision {

// The side, in pixels, of the block that becomes one pixel at working resolution. It is the
// smallest with which the longer side of the picture becomes at most 640.
int WorkingStep(cv::Size size);

// Means over blocks; the result has ceil(size / step) pixels.
cv::Mat ToWorkingSize(const cv::Mat& image, int step);

// |a - b|^2 of two colours.
inline float SquaredDifference(const cv::Vec3b& a, const cv::Vec3b& b) {
  const cv::Vec3f difference = cv::Vec3f(a) - cv::Vec3f(b);
  return difference.dot(difference);
}

// (ER2). image: B G R at full resolution; log_odds: (ER1).
cv::Mat1f RefineProbability(const cv::Mat3b& image, const cv::Mat1f& log_odds);

// Log odds of probabilities, which are first clamped to [0.002, 0.998]; and the inverse.
cv::Mat1f LogOdds(const cv::Mat1f& probability);
cv::Mat1f Probability(const cv::Mat1f& log_odds);

}  // namespace egosieve::vision
