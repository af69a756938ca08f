// Objects above the road in each column of the image, and their ground contact (ground_contact.h).
//
// Each column is read from the bottom upwards: places on the road first, then above them the first
// stretch of places of similar depth that is large enough. A smaller one may be motion that smooth
// flow carries onto the road. The stretch is one object. Its inverse depth is the median over its
// places.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/ground_contact.h"
#include "vision/evidence/road_plane.h"
#include "vision/evidence/surfaces.h"

namespace egosieve::vision {

enum class Ground { kRoad, kUnclear, kOff };

// From the grey levels (against_road) where they decide, else from depth.
Ground GroundOf(const RoadPlane& road, const InverseDepth& point);

// Evidence for a point from the ground contact of its column.
struct PointContact {
  bool judged = false;
  ContactRatios ratios;
};

struct ColumnView {
  const Raster& raster;  // of `places`
  const RoadPlane& road;
  const std::vector<InverseDepth>& points;
  const std::vector<cv::Point2f>& places;  // in the image, one per point
  const std::vector<Ground>& grounds;      // one per point
  const ContactPictures* pictures;         // null: contacts are found from depths alone
};

// One per point.
std::vector<PointContact> ContactsByColumn(const ColumnView& view);

// Whether two points may lie on one surface: their inverse depths differ by less than 2.5
// deviations plus a tenth of the larger.
bool IsAlike(const InverseDepth& a, const InverseDepth& b);

}  // namespace egosieve::vision
