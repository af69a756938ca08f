// Finds the own vehicle block by block while frames arrive: parts of the image that are fixed while
// the scene moves. Bonnet, wiper at rest, time stamp, logo. own_vehicle.h finds it from the whole
// drive.
//
// The image at half resolution, smoothed, is divided into blocks of 8 x 8. Between the frames t - g
// and t, with D = I_t - I_(t-g) and G the mean gradient of the two, a block of the static scene
// moves by v + s d, s >= 0: by v to the point at infinity, and on along the epipolar line (or by v
// alone, that of a homography). Three hypotheses for a block of N pixels, linear in the motion:
//
//   still   C_0 = sum D^2                                                                    (O1)
//   world   C_1 = min_{s >= 0} sum (D + G.(v + s d))^2                                       (O2)
//   other   C_2 = min_w sum (D + G.w)^2                                                      (O3)
//   l = clamp((C_1 - C_0) / (2 N sigma^2), -1, 1),  and -1 where the block is not still:
//       C_0 > 4 N sigma^2,  or  C_0 - C_2 > 9 sigma^2 and |w| > 0.15                         (O4)
//   A <- clamp(memory A + l, -limit, limit)                                                  (O5)
//
// If the road is known (road_plane.h), tracked points give more evidence: no static point is below
// the road, so points that do not move where the road moves are not part of the scene. l is 3 for
// blocks in which most points are of this kind, if such blocks continue, with short gaps, from the
// lower edge of the image up to the block. These show the bonnet with its reflections, and
// reflections in the windscreen, but not a car ahead, below which there is road. Such a block
// belongs to the own vehicle if A > off, after three frames.
//
// sigma is the image noise: the lower quartile of sqrt(C_0 / N) over the blocks, at least the
// floor. Distant points straight ahead do not move either, but v predicts that: C_1 = C_0, and
// nothing is learnt. An object that travels with the camera (the car ahead) does move by v when the
// camera turns. So the evidence needs turning and pitching, which occur in driving, and many
// frames. An object that a hand-held camera follows is fixed, too, but neither for long nor to a
// fraction of a pixel (O4). A block belongs to the own vehicle from A > on until A < off. Short
// gaps between such blocks, or between one and the lower edge, are filled unless they were seen to
// move.
//
// State: A and the flag of each block, and the half images of the last g frames. Cost: linear in
// the pixels.
#ifndef EGOSIEVE_VISION_OWN_VEHICLE_OWN_VEHICLE_BLOCKS_H_
#define EGOSIEVE_VISION_OWN_VEHICLE_OWN_VEHICLE_BLOCKS_H_

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"
#include "vision/evidence/road_plane.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct OwnVehicleBlocksOptions {
  double on = 25.0;          // positive, at most `limit`
  double off = 8.0;          // below `on`
  double limit = 50.0;       // of |A|
  double memory = 0.99;      // per frame; (0, 1)
  double noise_floor = 1.5;  // grey levels; positive

  absl::Status Validate() const;
};

struct OwnVehicleBlocks {
  struct HalfImage {
    int64_t index = -1;
    cv::Size size;
    std::vector<uint8_t> pixels;  // row-major
  };
  cv::Size blocks;
  std::vector<float> sums;        // A, row-major
  std::vector<uint8_t> is_own;    // flags
  std::vector<HalfImage> images;  // by increasing index
};

// Motion of the static scene between t - g and t: a homography, or a pose.
struct WorldMotion {
  bool has_line = false;                                     // d exists
  Eigen::Matrix3d homography = Eigen::Matrix3d::Identity();  // x + v ~ H x, pixels
  RelativePose pose;                                         // read if has_line
  Pinhole camera;
  RoadPlane road;                // read if has_line; need not be found
  std::vector<PointPair> pairs;  // textured places, t - g to t; read if the road is found
};

// Adds the frame to the state. Updates A if `motion` is not null and frame t - g is in the state.
// grey: CV_8UC1. `options` must be valid.
void LearnOwnVehicleBlocks(const cv::Mat& grey, int64_t index, int gap, const WorldMotion* motion,
                           const OwnVehicleBlocksOptions& options, OwnVehicleBlocks& state);

// Whether a place, in pixels of the full image, is on the own vehicle.
bool IsOwnVehicle(const OwnVehicleBlocks& state, cv::Point2f place);

// The areas of the own vehicle: runs of blocks in a row, from the top.
std::vector<cv::Rect> OwnVehicleAreas(const OwnVehicleBlocks& state, cv::Size image);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_OWN_VEHICLE_OWN_VEHICLE_BLOCKS_H_
