// The same scene point in the two frames of a pair: (x1, y1) in the first, (x2, y2) in the second,
// pixels.
#ifndef EGOSIEVE_VISION_GEOMETRY_POINT_PAIR_H_
#define EGOSIEVE_VISION_GEOMETRY_POINT_PAIR_H_

namespace egosieve::vision {

struct PointPair {
  double x1 = 0.0, y1 = 0.0;
  double x2 = 0.0, y2 = 0.0;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_GEOMETRY_POINT_PAIR_H_
