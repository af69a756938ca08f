#ifndef EGOSIEVE_VISION_GEOMETRY_POINT_PAIR_H_
#define EGOSIEVE_VISION_GEOMETRY_POINT_PAIR_H_

namespace egosieve::vision {

// The same scene point in the two frames of a pair, pixels.
struct PointPair {
  double x1 = 0.0, y1 = 0.0;
  double x2 = 0.0, y2 = 0.0;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_GEOMETRY_POINT_PAIR_H_
