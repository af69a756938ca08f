// Where things are expected next: they go on as they moved last.
//
//   v_c = median of (x2 - x1) / g   over the last pair's matches with x1 + (x2 - x1) / g in cell c
//   place of x after h pictures = x + h v(x)                                                (MF1)
//
// g pictures lay between the pair; cells are squares of 32 pixels, v is linear between their
// centres. A cell with fewer than three matches takes the mean of its neighbours, ring by ring. A
// field follows the depth of a street as no single homography does, and stays with it where the
// camera's motion is known to be a fundamental matrix only, which predicts a line but no place.
// Cost: linear in the matches.
#ifndef EGOSIEVE_VISION_MATCHING_MOTION_FIELD_H_
#define EGOSIEVE_VISION_MATCHING_MOTION_FIELD_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// columns x rows velocities, row by row, pixels a picture; empty where nothing is known.
struct MotionField {
  static constexpr int kCellPixels = 32;

  int32_t columns = 0, rows = 0;
  std::vector<cv::Point2f> velocities;

  bool empty() const { return velocities.empty(); }
};

// Empty where no cell has enough matches. Pairs that are not finite are left out. size, gap:
// positive.
MotionField MakeMotionField(const std::vector<PointPair>& pairs, int gap, cv::Size size);

// (MF1); the field must not be empty.
std::vector<cv::Point2f> PredictPlaces(const MotionField& field,
                                       const std::vector<cv::Point2f>& places, int pictures);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MATCHING_MOTION_FIELD_H_
