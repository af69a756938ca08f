// Whether an object touches the ground in the image row that its depth implies.
//
// With m.A_b the ground's inverse depth in row b (road_plane.h), an object of inverse depth r that
// stands on the ground reaches down to the row where m.A_b = r. Two pictures show which rows are
// object and which are ground. A strip of 7 x 3 pixels around row y is compared (S1) with its
// position in the frame before, if it moved like the ground there, and if it moved like an object
// of inverse depth r. With E_ground(y) and E_object(y) the two squared differences, kappa and v as
// in (S1),
//
//   g(y) = kappa (E_ground(y) - E_object(y)) / (2 v),   S(b) = sum of g over the rows to b     (B1)
//
// is the log-likelihood of a ground contact in row b, up to a constant. g is clamped in each row.
// A moving object may touch the ground in any row. For a static object the row must agree with r,
// up to a deviation s of depth and ground:
//
//   z_far(b)  = max(0, m.A_b - r) / s     farther than its ground contact
//   z_near(b) = max(0, r / (1 + h) - m.A_b) / s   nearer; h: it may hang above the ground, a bumper
//   l = max_b S(b) - max_b (S(b) - z(b)^2 / 2)                                                (B2)
//
// l is the log-likelihood ratio of moving against static; it is never negative. The ground is the
// plane, or the plane with its inverse depth scaled by the ratio that road places around the object
// show. E_ground is the smaller of the two differences, and z the smaller of the two deviations.
// Blank rows are no evidence: S is constant there. Without pictures, g comes from the inverse
// depths of the places that flow follows.
//
// Reference: Badino, Franke & Pfeiffer (2009), stixels: columns of ground and upright objects.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/road_plane.h"
#include "vision/geometry/pinhole.h"
#include "vision/geometry/relative_pose.h"

namespace egosieve::vision {

// A row below the top of an object.
struct ContactRow {
  double gain = 0.0;    // g of (B1); NaN where it cannot be measured
  double ground = 0.0;  // m.A
};

// The inverse depth r of an object with its deviation, and the ground around it.
struct ContactDepths {
  double inverse_depth = 0.0, deviation = 0.0;
  double ground_share = 1.0;  // inverse depth of the ground around the object over the plane's
  double unevenness = 0.0;    // deviation of the ground's inverse depth, a share of it
  double lowest = 0.0;        // the search ends at the row where m.A exceeds this
};

// (B2) for both signs of z, and m.A of the row of the greatest S.
struct ContactRatios {
  double too_far = 0.0, too_near = 0.0;
  double ground = 0.0;
};

// rows: from the top downwards; all results are 0 if empty.
ContactRatios RatiosOfContact(const std::vector<ContactRow>& rows, const ContactDepths& depths);

// ContactDepths::lowest of an object of inverse depth r, seen in a row where m.A is `ground`.
double LowestGround(double ground, double inverse_depth);

class ContactPictures {
 public:
  // pose: before to now, found; pictures: CV_8UC1 of one size; noise_levels: of PhotometricSupport.
  ContactPictures(const RoadPlane& road, const Pinhole& camera, const RelativePose& pose,
                  cv::Mat before, cv::Mat now, double noise_levels);

  // The rows from `top` downwards, for an object that is seen at `top`.
  std::vector<ContactRow> RowsBelow(cv::Point2f top, const ContactDepths& depths) const;

 private:
  double Gain(double x, double y, const ContactDepths& depths) const;

  RoadPlane road_;
  Pinhole camera_;
  RelativePose back_;  // now to before
  cv::Mat before_, now_;
  double noise_levels_;
};

}  // namespace egosieve::vision
