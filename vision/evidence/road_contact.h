// Points that stand neither on the road nor on anything that stands on it.
//
// With r a point's inverse depth, A its ray and m.A the road's inverse depth there (road_plane.h),
// a static point is not below the road,
//
//   r >= m.A                                                                                 (R2)
//
// with slack, for roads are not plane, and what stands on the road has the road's depth where it
// touches it. A stretch of alike points in a column of the image, below which road is seen, has its
// ground contact there (ground_contact.h) unless it rises more than kMostRise camera heights above
// the camera: houses and trees do. A car ahead seems too far for its contact, infinitely far at
// equal speed; an oncoming one too near: with v_o its speed and v the camera's, (v_o + v) / v times
// as near. Both hold whatever the direction of the epipolar lines. The road's inverse depth is the
// plane's, times what the places of road around the object have of it.
//
// Flow is smooth and carries a mover's motion some places over the road below it, where the
// pictures know better: against_road tells road from what is not, and (R2) says no more than it.
// Lane lines and walls along the road slide along themselves, and the road's place is only known as
// well as its speed is: nor does (R2) say more than against_static, which asks for all depths from
// the road's on. Of what is too near, the columns of one surface (surfaces.h) speak for all of it,
// those without a contact in sight included: the mean of what they say, less where few of its
// columns have one, nothing where it is taller than a vehicle. One column alone often takes for its
// contact what is the blank side of a car in front.
//
// Nothing is said without a plane. Reference: Klappstein, Stein & Franke (2006), positive height
// constraint.
#ifndef EGOSIEVE_VISION_EVIDENCE_ROAD_CONTACT_H_
#define EGOSIEVE_VISION_EVIDENCE_ROAD_CONTACT_H_

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/evidence/ground_contact.h"
#include "vision/evidence/photometric_support.h"
#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"
#include "vision/evidence/road_plane.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// What the pictures say for the places of a pair against those of a point of the road (S1), signed;
// nothing above the horizon, 0 where they do not say. camera, pose: as for InverseDepths.
class RoadComparison {
 public:
  RoadComparison(const Pinhole& camera, const RelativePose& pose,
                 const PhotometricSupport& pictures);

  std::optional<double> AgainstRoad(const RoadPlane& road, const PointPair& pair) const;
  // (S2) against everything static: from the road's inverse depth, less the slack of (R2), on.
  std::optional<double> AgainstStatic(const RoadPlane& road, const PointPair& pair) const;

 private:
  Pinhole camera_;
  RelativePose back_;
  PhotometricSupport reversed_;
};

// Sets against_road of the points that are below the horizon, one a pair.
void CompareWithRoad(const RoadPlane& road, const RoadComparison& comparison,
                     const std::vector<PointPair>& pairs, std::vector<InverseDepth>& points);

// Log-likelihood ratio by (R2) and the ground contact, not negative, one per point; places: of the
// points, in the image; pictures: null without.
std::vector<double> RoadLogRatios(const RoadPlane& road, const std::vector<InverseDepth>& points,
                                  const std::vector<cv::Point2f>& places, cv::Size image,
                                  const ContactPictures* pictures);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_ROAD_CONTACT_H_
