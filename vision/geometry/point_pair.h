// The same scene point in the two frames of a pair: (x1, y1) in the first, (x2, y2) in the second,
// pixels.
#pragma once

namespace egosieve::vision {

struct PointPair {
  double x1 = 0.0, y1 = 0.0;
  double x2 = 0.0, y2 = 0.0;
};

}  // namespace egosieve::vision
