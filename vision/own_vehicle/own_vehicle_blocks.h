// The own vehicle found on the way, block by block: parts of the image that stand still while the
// world moves. Bonnet, wiper at rest, time stamp, logo. own_vehicle.h finds it from the whole drive.
//
// The image at half resolution, smoothed, in blocks of 8 x 8. Between the frames t - g and t, with
// D = I_t - I_(t-g) and G the mean gradient of the two, a block of a static world moves by v + s d,
// s >= 0: v to the point at infinity and on along the epipolar line (or by v alone, that of a
// homography). Three hypotheses for a block of N pixels, linear in the motion:
//
//   still   C_0 = sum D^2                                                                    (O1)
//   world   C_1 = min_{s >= 0} sum (D + G.(v + s d))^2                                       (O2)
//   other   C_2 = min_w sum (D + G.w)^2                                                      (O3)
//   l = clamp((C_1 - C_0) / (2 N sigma^2), -1, 1),  and -1 where the block is not still:
//       C_0 > 4 N sigma^2,  or  C_0 - C_2 > 9 sigma^2 and |w| > 0.15                         (O4)
//   A <- clamp(memory A + l, -limit, limit)                                                  (O5)
//
// Where the road is known (road_plane.h), places that were followed say more: nothing of a static
// world is below the road, so what is still where the road moves is not the world. l is 3 for
// blocks most of whose places are, as far as such blocks reach up from the lower edge of the image:
// a bonnet, whatever it mirrors, and what the windscreen mirrors; a car ahead has road below it.
// Such a block belongs to the own vehicle from A > off on, after three frames. (To ask for a still
// edge at their upper end left the windscreen's reflections on blank asphalt to be called movers.)
//
// sigma is the image noise: the lower quartile of sqrt(C_0 / N) over the blocks, at least the
// floor. What is far away and straight ahead also stands still, but v then says so: C_1 = C_0, and
// nothing is learnt. What travels along (the car ahead) does turn with the camera: v holds for it
// too. So it takes turning and pitching, which driving has, and many frames: what a camera follows
// by hand keeps its place, too, but neither for long nor to a fraction of a pixel (O4). A block
// belongs to the own vehicle from A > on until A < off, and so do some blocks without texture
// between such blocks, or between one and the lower edge.
//
// State: A and the flag of each block, and the half images of the last g frames. Cost: about 2 ms
// at 1242 x 375.
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
  double memory = 0.99;      // a frame; (0, 1)
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

// How a static world moves between t - g and t: a homography, or rotation and travel.
struct WorldMotion {
  bool has_line = false;                                     // d exists
  Eigen::Matrix3d homography = Eigen::Matrix3d::Identity();  // x + v ~ H x, pixels
  RelativePose pose;                                         // read where has_line
  Pinhole camera;
  RoadPlane road;                // read where has_line; need not be found
  std::vector<PointPair> pairs;  // places with texture, t - g to t; read where the road is found
};

// Takes the frame in; learns where `motion` is not null and frame t - g is among those kept.
// grey: CV_8UC1. `options` must be valid.
void LearnOwnVehicleBlocks(const cv::Mat& grey, int64_t index, int gap, const WorldMotion* motion,
                           const OwnVehicleBlocksOptions& options, OwnVehicleBlocks& state);

// Whether a place, in pixels of the whole image, is the own vehicle's.
bool IsOwnVehicle(const OwnVehicleBlocks& state, cv::Point2f place);

// All such places of an image: stretches of rows of blocks, from the top.
std::vector<cv::Rect> OwnVehicleAreas(const OwnVehicleBlocks& state, cv::Size image);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_OWN_VEHICLE_OWN_VEHICLE_BLOCKS_H_
