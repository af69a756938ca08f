#include "vision/labelling/drive_camera.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "kernels/base/status_macros.h"
#include "vision/own_vehicle/mount_shake.h"
#include "vision/own_vehicle/windscreen.h"
#include "vision/trajectory/bundle_adjustment.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {
namespace {

constexpr int64_t kFewestLinks = 100;
// Of the lowest part of the picture, share of own vehicle that shows the camera to shake on its mount.
constexpr double kLeastOfLowest = 0.1;

Pinhole CameraOf(cv::Size size, double focal_ratio) {
  return Pinhole::Of(size, focal_ratio * std::max(size.width, size.height));
}

// Time from pair k to the next pair, over the time between the two pictures of pair k; at least 1.
double TimesAsLong(const std::vector<PicturePair>& pairs, size_t k) {
  const double length = pairs[k].length_seconds();
  if (k + 1 >= pairs.size() || !(length > 0.0)) return 1.0;
  return std::max(1.0, (pairs[k + 1].seconds() - pairs[k].seconds()) / length);
}

// The pairs with enough links in the part of the image that is not fixed.
std::vector<PairWorld> PairsOfTheWorld(const DrivePictures& drive, const FixedPlaces& fixed,
                                       const Pinhole& camera) {
  std::vector<PairWorld> found;
  for (size_t k = 0; k < drive.pairs.size(); ++k) {
    std::vector<PointPair> links = drive.pairs[k].links;
    std::erase_if(links, [&](const PointPair& p) {
      return fixed.IsFixedIn(k, p.x1, p.y1) || fixed.IsFixedIn(k, p.x2, p.y2);
    });
    if (static_cast<int64_t>(links.size()) < kFewestLinks) continue;
    const TwoViewMotion motion = EstimateTwoViewMotion(links, camera, {});
    found.push_back(
        {motion, TimesAsLong(drive.pairs, k), LeastGroundSlope(links, motion, camera), k});
  }
  return found;
}

// The windows without tracks of places that are fixed in the image.
std::vector<TrackWindow> WindowsOfTheWorld(std::vector<TrackWindow> windows,
                                           const FixedPlaces& fixed) {
  for (TrackWindow& window : windows) {
    std::erase_if(window.tracks, [&](const std::vector<cv::Point2d>& track) {
      return fixed.IsFixed(track.front().x, track.front().y) &&
             fixed.IsFixed(track.back().x, track.back().y);
    });
  }
  return windows;
}

// Adds a mask to another; either may be empty.
void Add(const cv::Mat1b& mask, cv::Mat1b& sum) {
  if (mask.empty()) return;
  sum = sum.empty() ? mask : cv::Mat1b(sum | mask);
}

// The first or second pictures of the pairs.
std::vector<cv::Mat1b> Reduced(const DrivePictures& drive, int which) {
  std::vector<cv::Mat1b> pictures;
  for (const PicturePair& pair : drive.pairs) pictures.push_back(pair.reduced[which]);
  return pictures;
}

// Adds what a camera that shakes on its mount sees of its vehicle and windscreen.
void AddShaken(const DrivePictures& drive, const Pinhole& learnt, DriveCamera& camera) {
  const FixedPlaces places = FindFixedOnMount(Reduced(drive, 0), drive.size);
  // Most of what is proven is of these; motions cost more than this look.
  if (places.kind.empty() || ShareOfLowest(places.kind == FixedPlaces::kFixed) < kLeastOfLowest) {
    return;
  }
  const std::vector<PairWorld> pairs = PairsOfTheWorld(drive, places, learnt);
  const cv::Mat1b own = ProveOwnVehicle(places, pairs, learnt);
  if (ShareOfLowest(own) < kLeastOfLowest) return;
  Add(own, camera.own_vehicle);
  Add(FindWindscreen(places, Reduced(drive, 1), pairs, learnt), camera.windscreen);
}

}  // namespace

absl::StatusOr<DriveCamera> LearnDriveCamera(FrameSource& source,
                                             const DriveCameraOptions& options) {
  DrivePicturesOptions pictures_options = options.pictures;
  const bool is_given = options.focal_ratio > 0.0;
  if (is_given) pictures_options.windows = 0;
  EGOSIEVE_ASSIGN_OR_RETURN(DrivePictures drive, ReadDrivePictures(source, pictures_options));
  DriveCamera camera;
  FixedPlaces fixed;
  if (options.finds_own_vehicle) {
    fixed = FindFixedPlaces(Reduced(drive, 0), drive.size);
    camera.fixed_pattern = fixed.median;
  }
  if (is_given) {
    camera.focal_ratio = options.focal_ratio;
  } else {
    const std::vector<TrackWindow> windows = WindowsOfTheWorld(std::move(drive.windows), fixed);
    AdjustedLens lens = AdjustLens(windows, drive.size);
    if (lens.k1 != 0.0 && !LensCorrection::Create(LensOf(lens, drive.size), drive.size).ok()) {
      lens = AdjustLens(windows, drive.size, Distortion::kNone);
    }
    camera.focal_ratio = lens.focal_ratio;
    camera.log_focal_deviation = lens.log_focal_deviation;
    if (lens.k1 != 0.0) {
      camera.lens = LensOf(lens, drive.size);
      return camera;
    }
  }
  if (drive.pairs.empty()) return camera;
  const Pinhole learnt = CameraOf(drive.size, camera.focal_ratio);
  const std::vector<PairWorld> pairs = PairsOfTheWorld(drive, fixed, learnt);
  camera.pair_count = static_cast<int>(pairs.size());
  std::vector<Eigen::Vector3d> directions;
  for (const PairWorld& pair : pairs) {
    const TwoViewMotion& motion = pair.motion;
    if (!motion.HasParallax()) continue;
    directions.push_back(motion.rotation.transpose() * motion.translation);
  }
  camera.travel = FitTravelPrior(directions);
  camera.own_vehicle = ProveOwnVehicle(fixed, pairs, learnt);
  if (camera.travel.IsOfVehicle()) {
    // Pairs that disagree with the direction are attributed to wrong estimates of motion.
    camera.travel.share = 1.0 - TravelPrior::kVehicleTravelsElsewhere;
    camera.windscreen = FindWindscreen(fixed, Reduced(drive, 1), pairs, learnt);
    if (options.finds_own_vehicle) AddShaken(drive, learnt, camera);
  }
  if (options.pictures.lens != nullptr) {
    camera.own_vehicle = options.pictures.lens->DistortMask(camera.own_vehicle);
  }
  return camera;
}

}  // namespace egosieve::vision
