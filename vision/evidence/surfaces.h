// The points of an image in surfaces of one depth.
//
// Points lie in the cells of a raster, and one speaks for its cell. Those of neighbouring cells are
// joined where they are alike, the most alike first, and where the means of what they are part of
// are alike, too:
//
//   |r_a - r_b| < 2 sigma + 0.1 max(|r_a|, |r_b|),   r, sigma: means over the surface          (U1)
//
// Flow is smooth, and joined by neighbours alone a car would be one with the house behind it.
// Reference: Felzenszwalb & Huttenlocher (2004), the order of joining. Cost: n log n.
#ifndef EGOSIEVE_VISION_EVIDENCE_SURFACES_H_
#define EGOSIEVE_VISION_EVIDENCE_SURFACES_H_

#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "vision/evidence/road_plane.h"

namespace egosieve::vision {

// Square cells, about one a place.
class Raster {
 public:
  Raster(const std::vector<cv::Point2f>& places, cv::Size image);

  int rows() const { return rows_; }
  int columns() const { return columns_; }
  // The index of the place that speaks for a cell; -1: none.
  int At(int row, int column) const { return speakers_[row * columns_ + column]; }
  // Row and column.
  std::pair<int, int> CellAt(cv::Point2f place) const {
    return {CellOf(place) / columns_, CellOf(place) % columns_};
  }
  int SpeakerFor(cv::Point2f place) const { return speakers_[CellOf(place)]; }

 private:
  int CellOf(cv::Point2f place) const;

  double cell_pixels_;
  int columns_, rows_;
  std::vector<int> speakers_;
};

// The surface of each point; -1 for those that are not `is_part`, and for those that do not speak.
// Surfaces are numbered from 0.
std::vector<int> FindSurfaces(const Raster& raster, const std::vector<InverseDepth>& points,
                              const std::vector<bool>& is_part);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_SURFACES_H_
