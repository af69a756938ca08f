// Whether what is seen in a column of the image stands on the ground where its depth says.
//
// With m.A_b the ground's inverse depth in row b (road_plane.h), an object of inverse depth r that
// stands on the ground reaches down to the row where m.A_b = r. Which rows are object and which are
// ground, the pictures tell: with E_ground(y) and E_object(y) what a strip of 7 x 3 pixels around
// row y differs by from its place in the frame before (S1), moved as the ground is there, or as
// something of inverse depth r,
//
//   g(y) = kappa (E_ground(y) - E_object(y)) / (2 v),   S(b) = sum of g over the rows above b  (B1)
//
// is the log-likelihood of a ground contact in row b, up to a constant; g is bounded row by row.
// Something that moves may touch the ground in any row. For something static the row must agree
// with r, up to a deviation s of depth and ground:
//
//   z_far(b)  = max(0, m.A_b - r) / s             farther than its ground contact
//   z_near(b) = max(0, r / (1 + h) - m.A_b) / s   nearer; h: it may hang above the ground, a bumper
//   l = max_b S(b) - max_b (S(b) - z(b)^2 / 2)                                                (B2)
//
// l is the log-likelihood ratio, never negative. The ground is the plane, or lies a share of its
// inverse depth higher or lower, as the places of road around the object show it: E_ground is the
// smaller of both differences, and z the smaller of both deviations. Blank rows say nothing, S is
// flat there. Without pictures g is that of the places that flow follows, by what they measure of
// r.
//
// Reference: Badino, Franke & Pfeiffer (2009), stixels: columns of ground and upright objects.
#ifndef EGOSIEVE_VISION_EVIDENCE_GROUND_CONTACT_H_
#define EGOSIEVE_VISION_EVIDENCE_GROUND_CONTACT_H_

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"
#include "vision/evidence/road_plane.h"

namespace egosieve::vision {

// A row below the top of an object.
struct ContactRow {
  double gain = 0.0;    // g of (B1); not a number where nothing is seen
  double ground = 0.0;  // m.A
};

// Of an object: its inverse depth r with its deviation, and the ground's around it.
struct ContactDepths {
  double inverse_depth = 0.0, deviation = 0.0;
  double ground_share = 1.0;  // of the plane's inverse depth, around the object
  double unevenness = 0.0;    // deviation of the ground's inverse depth, a share of it
  double lowest = 0.0;        // the ground's down to which the contact is looked for
};

// (B2) for both signs of z, and m.A of the row of the greatest S.
struct ContactRatios {
  double too_far = 0.0, too_near = 0.0;
  double ground = 0.0;
};

// rows: downwards. Zero without any.
ContactRatios RatiosOfContact(const std::vector<ContactRow>& rows, const ContactDepths& depths);

// ContactDepths::lowest of an object of inverse depth r that is seen where the ground has `ground`.
double LowestGround(double ground, double inverse_depth);

class ContactPictures {
 public:
  // pose: before to now, found; pictures: CV_8UC1 of one size; noise_levels: of PhotometricSupport.
  ContactPictures(const RoadPlane& road, const Pinhole& camera, const RelativePose& pose,
                  cv::Mat before, cv::Mat now, double noise_levels);

  // The rows below `top` for something that is seen there.
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

#endif  // EGOSIEVE_VISION_EVIDENCE_GROUND_CONTACT_H_
