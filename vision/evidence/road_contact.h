// Points that stand neither on the road nor on anything that stands on it.
//
// With r a point's inverse depth, A its ray and m.A the road's inverse depth there (road_plane.h),
// a static point is not below the road,
//
//   r >= m.A                                                                                 (R2)
//
// and what stands on the road has the road's depth at its foot. A stretch of alike points in a
// column of the image, below which road is seen, has its foot there:
//
//   r_stretch = m.A_foot                                                                     (R3)
//
// and the stretch rises no more than kMostRise camera heights above the camera: houses and trees
// do. A car ahead seems too far for its foot, infinitely far at equal speed; an oncoming one too
// near: with v_o its speed and v the camera's, (v_o + v) / v times as near. Both hold whatever the
// direction of the epipolar lines. (R2) and (R3) have slack, for roads are not plane and bumpers
// hang above them.
//
// Flow is smooth and carries a mover's motion some places over the road below it, where the
// pictures know better: against_road tells road from what is not, and (R2) says no more than it;
// the foot of what is too near is looked for in the pictures, row by row (foot_search.h). And of
// what is too near, the columns of one surface (surfaces.h) speak for all of it, those without a
// foot in sight included: the mean of what they say, less where few of its columns have a foot,
// nothing where it is taller than a vehicle. One column alone often takes for its foot what is the
// blank side of a car in front.
//
// Nothing is said without a plane. Reference: Klappstein, Stein & Franke (2006), positive height
// constraint.
#ifndef EGOSIEVE_VISION_EVIDENCE_ROAD_CONTACT_H_
#define EGOSIEVE_VISION_EVIDENCE_ROAD_CONTACT_H_

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/evidence/foot_search.h"
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

 private:
  Pinhole camera_;
  RelativePose back_;
  PhotometricSupport reversed_;
};

// Sets against_road of the points that are below the horizon, one a pair.
void CompareWithRoad(const RoadPlane& road, const RoadComparison& comparison,
                     const std::vector<PointPair>& pairs, std::vector<InverseDepth>& points);

// Log-likelihood ratio by (R2) and (R3), not negative, one a point; places: of the points, in the
// image; feet: null without pictures.
std::vector<double> RoadLogRatios(const RoadPlane& road, const std::vector<InverseDepth>& points,
                                  const std::vector<cv::Point2f>& places, cv::Size image,
                                  const FootSearch* feet);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_ROAD_CONTACT_H_
