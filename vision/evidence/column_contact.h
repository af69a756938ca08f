// What each column of the image shows above the road, and whether it stands there
// (ground_contact.h).
//
// From the bottom upwards: places of road, then the first stretch of alike places above them that
// is more than what smooth flow carries over the road. The stretch is one object, of the median of
// its places' inverse depths.
#ifndef EGOSIEVE_VISION_EVIDENCE_COLUMN_CONTACT_H_
#define EGOSIEVE_VISION_EVIDENCE_COLUMN_CONTACT_H_

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/ground_contact.h"
#include "vision/evidence/road_plane.h"
#include "vision/evidence/surfaces.h"

namespace egosieve::vision {

enum class Ground { kRoad, kUnclear, kOff };

// By the pictures where they tell, else by depth.
Ground GroundOf(const RoadPlane& road, const InverseDepth& point);

// What its column's ground contact says of a point.
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
  const ContactPictures* pictures;         // null without
};

// One per point.
std::vector<PointContact> ContactsByColumn(const ColumnView& view);

// Of what may be one surface: by 2.5 deviations and a tenth of what they are.
bool IsAlike(const InverseDepth& a, const InverseDepth& b);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_COLUMN_CONTACT_H_
