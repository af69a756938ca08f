// Predicts image positions: every point continues with its last motion.
//
//   v_c = median of (x2 - x1) / g   over the last pair's matches with x1 + (x2 - x1) / g in cell c
//   position of x after h pictures = x + h v(x)                                             (MF1)
//
// The pair was g pictures apart. Cells are squares of 32 pixels, and v is linear between their
// centres. A cell with fewer than three matches takes the mean of its neighbours, ring by ring. A
// field follows the depth of a street, which no single homography does. It is also used where the
// camera's motion is known only as a fundamental matrix, which predicts a line but no position.
// Cost: linear in the matches.
#ifndef EGOSIEVE_VISION_MATCHING_MOTION_FIELD_H_
#define EGOSIEVE_VISION_MATCHING_MOTION_FIELD_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// columns x rows velocities, row by row, pixels per picture; empty where nothing is known.
struct MotionField {
  static constexpr int kCellPixels = 32;

  int32_t columns = 0, rows = 0;
  std::vector<cv::Point2f> velocities;

  bool empty() const { return velocities.empty(); }
};

// Empty if no cell has enough matches. Pairs that are not finite are ignored. size, gap: positive.
MotionField MakeMotionField(const std::vector<PointPair>& pairs, int gap, cv::Size size);

// (MF1); the field must not be empty.
std::vector<cv::Point2f> PredictPlaces(const MotionField& field,
                                       const std::vector<cv::Point2f>& places, int pictures);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MATCHING_MOTION_FIELD_H_
