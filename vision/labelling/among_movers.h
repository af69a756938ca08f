// Which places of a picture lie among places that move.
//
// Where nothing is known of a place (fusion.h), as in the blank parts of a mover, it is left to the
// Gaussian process if it lies among movers: the process then interpolates. What lies beside them,
// such as a blank sky, is not left to it, since there it would extrapolate. A place lies among
// movers if one moves in each of the four quarters around it, no farther away than kReach in either
// direction. By dx > 0, dy >= 0 and its turns by right angles, the quarters share no place.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

class AmongMovers {
 public:
  static constexpr double kReach = 0.1;  // of the picture's longer side

  // moving: inside the picture, pixels. cell: pixels, positive; distances are in whole cells.
  AmongMovers(const std::vector<cv::Point2f>& moving, cv::Size picture, int cell);

  // place: inside the picture, pixels.
  bool Has(cv::Point2f place) const;

 private:
  cv::Point CellOf(cv::Point2f place) const;

  int cell_, reach_;  // pixels, cells
  cv::Mat1i count_;   // of cells with a mover above and left of each corner
};

}  // namespace egosieve::vision
