// Evidence against points that lie neither on the road nor on a static object on the road.
//
// With r a point's inverse depth, A its ray and m.A the road's inverse depth there (road_plane.h),
// a static point is not below the road,
//
//   r >= m.A                                                                                 (R3)
//
// with slack, because roads are not plane. An object on the road has the road's depth at its ground
// contact. A stretch of similar points in a column of the image with road below it has its ground
// contact there (column_contact.h, ground_contact.h). A car ahead seems too far for its contact,
// infinitely far at equal speed. An oncoming car seems too near: (v_o + v) / v times as near, with
// v_o its speed and v the camera's. Both hold for every direction of the epipolar lines. A stretch
// that rises more than kMostRise camera heights above the camera (a house, a tree) cannot count as
// too near, and only its lower part can count as too far. The road's inverse depth is the plane's,
// times the ratio that road places around the object show.
//
// Flow is smooth and carries a mover's motion onto a few places of the road below it. Grey levels
// correct this: against_road compares each point with the road, and limits (R3). In one column
// alone, the blank side of a car in front is often mistaken for the ground contact. Therefore all
// columns of one surface (surfaces.h) are judged together, also those without a visible contact.
// The surface's ratio is the larger of its columns' two medians (too far, too near). It is reduced
// if few of the columns have a contact, and 0 if the surface is taller than a vehicle.
//
// Reference: Klappstein, Stein & Franke (2006), positive height
// constraint.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/ground_contact.h"
#include "vision/evidence/photometric_support.h"
#include "vision/evidence/road_plane.h"
#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/geometry/relative_pose.h"

namespace egosieve::vision {

// Sets against_road of the points below the horizon: log-likelihood ratios from grey levels of the
// positions of a pair against those of a point on the road (S1), signed, 0 where a patch leaves its
// picture. camera, pose: as for InverseDepths; points: one per pair.
void CompareWithRoad(const RoadPlane& road, const Pinhole& camera, const RelativePose& pose,
                     const PhotometricSupport& pictures, const std::vector<PointPair>& pairs,
                     std::vector<InverseDepth>& points);

// Log-likelihood ratio by (R3) and the ground contact, not negative, one per point. places: of the
// points in the image. pictures: null: contacts are found from depths alone.
std::vector<double> RoadLogRatios(const RoadPlane& road, const std::vector<InverseDepth>& points,
                                  const std::vector<cv::Point2f>& places, cv::Size image,
                                  const ContactPictures* pictures);

}  // namespace egosieve::vision
