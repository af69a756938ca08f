#include "vision/labelling/drive_camera.h"

#include <algorithm>
#include <iterator>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/features/flow_grid.h"
#include "vision/labelling/reduced_labels.h"
#include "vision/trajectory/focal_posterior.h"
#include "vision/trajectory/ground_direction.h"
#include "vision/trajectory/ground_search.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {
namespace {

constexpr double kPairSeconds = 0.08;    // from the first picture of a pair to the second, at least
constexpr double kGroundSeconds = 0.15;  // from the first picture to the last that shows the ground
constexpr int kLongestPair = 6;          // frames
constexpr int kGridStride = 10;          // pixels
constexpr int kLongestSide = 1280;       // of the pictures that flow is computed on
constexpr int64_t kFewestLinks = 100;
constexpr int64_t kUnknownLength = 600;  // frames, where the source does not know its own

struct TimedPicture {
  cv::Mat grey;  // equalised, reduced to kLongestSide
  double seconds = 0.0;
};

struct PicturePair {
  cv::Size size;                       // as they were taken
  std::vector<TimedPicture> pictures;  // the first of the pair, and those after it
  size_t second = 0;                   // of the pair, in `pictures`
  cv::Mat1b reduced;                   // of the first (fixed_pattern.h), not equalised

  double seconds() const { return pictures[0].seconds; }
  double length_seconds() const { return pictures[second].seconds - pictures[0].seconds; }
};

// What is kept of a pair.
struct LinkedPair {
  PicturePair pictures;
  std::vector<PointPair> links;  // between places with texture
};

// Nothing at the end of the input, and where the pictures of a pair cannot be used. most_pictures:
// as many are read, or until the pair is whole.
absl::StatusOr<std::optional<PicturePair>> ReadPair(FrameSource& source,
                                                    const EqualizationOptions& equalization,
                                                    int64_t most_pictures) {
  PicturePair pair;
  for (int k = 0; k <= kLongestPair; ++k) {
    EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source.Next());
    if (std::holds_alternative<EndOfFrames>(read)) break;
    auto* frame = std::get_if<Frame>(&read);
    if (frame == nullptr) continue;
    if (pair.pictures.empty()) {
      pair.size = frame->image.size();
      pair.reduced = ReducedPicture(EqualizedGrey(frame->image, {}));
    }
    if (frame->image.size() != pair.size) break;
    pair.pictures.push_back({EqualizedGrey(ReducePicture(frame->image, kLongestSide), equalization),
                             frame->time_seconds});
    const double length = frame->time_seconds - pair.seconds();
    if (pair.second == 0 && (length >= kPairSeconds || k == kLongestPair)) {
      pair.second = pair.pictures.size() - 1;
    }
    if (length >= kGroundSeconds || (pair.second > 0 && k + 1 >= most_pictures)) break;
  }
  if (pair.second == 0) return std::nullopt;
  return pair;
}

// In pixels of the pictures as they were taken.
absl::StatusOr<std::vector<PointPair>> Links(const PicturePair& pictures,
                                             const cv::Mat1b& ignored) {
  std::vector<PointPair> links;
  const cv::Mat &first = pictures.pictures[0].grey,
                &second = pictures.pictures[pictures.second].grey;
  if (!IsLargeEnoughForFlow(first.size())) return links;
  FlowGridOptions options;
  options.stride_pixels = kGridStride;
  options.ignored = ReduceMask(ignored, kLongestSide);
  EGOSIEVE_ASSIGN_OR_RETURN(const FlowPair flow, ComputeFlow(first, second, options.quality));
  const TrackedGrid grid = TrackGrid(flow, first, second, /*anchor_second=*/true, options);
  for (size_t i = 0; i < grid.pairs.size(); ++i) {
    if (grid.is_textured[i] == 0) continue;
    links.push_back(EnlargePair(grid.pairs[i], first.size(), pictures.size));
  }
  return links;
}

struct DrivePairs {
  cv::Size size;
  std::vector<LinkedPair> pairs;  // of pictures of that size
};

absl::StatusOr<DrivePairs> ReadPairs(FrameSource& source, const DriveCameraOptions& options) {
  const int64_t known = source.expected_frame_count() - options.first_frame;
  const int64_t length = std::min(known > 0 ? known : kUnknownLength, options.longest_frames);
  const int64_t step = std::max<int64_t>(length / options.pairs, 1);
  DrivePairs drive;
  for (int k = 0; k < options.pairs; ++k) {
    const int64_t index = options.first_frame + k * step;
    if (index < source.next_index()) continue;
    EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(index));
    EGOSIEVE_ASSIGN_OR_RETURN(std::optional<PicturePair> pictures,
                              ReadPair(source, options.equalization, step));
    if (!pictures) continue;
    if (drive.pairs.empty()) drive.size = pictures->size;
    if (pictures->size != drive.size) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<PointPair> links, Links(*pictures, options.ignored));
    drive.pairs.push_back({*std::move(pictures), std::move(links)});
  }
  return drive;
}

Pinhole CameraOf(cv::Size size, double focal_ratio) {
  return Pinhole::Of(size, focal_ratio * std::max(size.width, size.height));
}

// How many times as long it is to the next pair as between the two pictures of pair k.
double TimesAsLong(const std::vector<LinkedPair>& pairs, size_t k) {
  const double length = pairs[k].pictures.length_seconds();
  if (k + 1 >= pairs.size() || !(length > 0.0)) return 1.0;
  return std::max(1.0, (pairs[k + 1].pictures.seconds() - pairs[k].pictures.seconds()) / length);
}

// A pair that moves enough places of the world.
struct WorldPair {
  const LinkedPair* pair = nullptr;
  std::vector<PointPair> links;  // of what is not fixed in the image
  TwoViewMotion motion;
  double times_as_long = 1.0;  // TimesAsLong
};

// posterior: learns from each pair; focal_ratio: 0 where it is to be learnt.
std::vector<WorldPair> PairsOfTheWorld(const DrivePairs& drive, const FixedPlaces& fixed,
                                       double focal_ratio, FocalPosterior& posterior) {
  std::vector<WorldPair> found;
  for (size_t k = 0; k < drive.pairs.size(); ++k) {
    WorldPair world;
    world.pair = &drive.pairs[k];
    std::copy_if(world.pair->links.begin(), world.pair->links.end(),
                 std::back_inserter(world.links), [&](const PointPair& p) {
                   return !fixed.IsFixed(p.x1, p.y1) && !fixed.IsFixed(p.x2, p.y2);
                 });
    if (static_cast<int64_t>(world.links.size()) < kFewestLinks) continue;
    const Pinhole guess =
        CameraOf(drive.size, focal_ratio > 0.0 ? focal_ratio : posterior.Estimate());
    world.motion = EstimateTwoViewMotion(world.links, guess, {});
    world.times_as_long = TimesAsLong(drive.pairs, k);
    posterior.Observe(world.links, guess, world.motion, drive.size);
    found.push_back(std::move(world));
  }
  return found;
}

cv::Mat1b United(const cv::Mat1b& a, const cv::Mat1b& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return a | b;
}

// The direction of `travel`, sharpened by the ground. ignored: of the pictures as they were taken.
Eigen::Vector3d SharpenedDirection(const TravelPrior& travel, const std::vector<WorldPair>& worlds,
                                   double focal_ratio, const cv::Mat1b& ignored) {
  std::vector<GroundSearchView> views;
  for (const WorldPair& world : worlds) {
    const PicturePair& pair = world.pair->pictures;
    GroundSearchView& view = views.emplace_back();
    view.camera = CameraOf(pair.pictures[0].grey.size(), focal_ratio);
    view.ignored = ReduceMask(ignored, kLongestSide);
    for (const TimedPicture& picture : pair.pictures) {
      const double later = picture.seconds - pair.seconds();
      view.pictures.push_back(
          {picture.grey, later,
           PartOfRotation(world.motion.rotation, later / pair.length_seconds())});
    }
  }
  return DirectionByGround(travel, std::move(views));
}

}  // namespace

absl::Status DriveCameraOptions::Validate() const {
  if (pairs < 1 || longest_frames < 1 || first_frame < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("pairs is ", pairs, ", longest_frames ", longest_frames, ", first_frame ",
                     first_frame, "; they must be positive, the last not negative"));
  }
  EGOSIEVE_RETURN_IF_ERROR(own_vehicle.Validate());
  return equalization.Validate();
}

absl::StatusOr<DriveCamera> LearnDriveCamera(FrameSource& source,
                                             const DriveCameraOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(const DrivePairs drive, ReadPairs(source, options));
  DriveCamera camera;
  std::vector<cv::Mat1b> pictures;
  for (const LinkedPair& pair : drive.pairs) pictures.push_back(pair.pictures.reduced);
  FixedPlaces fixed;
  if (options.finds_own_vehicle) {
    fixed = FindFixedPlaces(pictures, drive.size, options.own_vehicle);
    camera.fixed_pattern = fixed.median;
  }
  FocalPosterior posterior;
  std::vector<WorldPair> worlds = PairsOfTheWorld(drive, fixed, options.focal_ratio, posterior);
  const bool is_given = options.focal_ratio > 0.0;
  camera.pair_count = static_cast<int>(worlds.size());
  camera.focal_ratio = is_given ? options.focal_ratio : posterior.Estimate();
  camera.log_focal_deviation = is_given ? 0.0 : posterior.LogDeviation();
  if (drive.pairs.empty()) return camera;
  const Pinhole learnt = CameraOf(drive.size, camera.focal_ratio);
  std::vector<PairWorld> pairs;
  std::vector<Eigen::Vector3d> directions;
  for (WorldPair& world : worlds) {
    TwoViewMotion& motion = world.motion;
    motion = RefineTwoViewMotion(world.links, learnt, motion, {});
    pairs.push_back({motion, world.times_as_long, LeastGroundSlope(world.links, motion, learnt)});
    if (motion.HasParallax()) {
      directions.push_back(motion.rotation.transpose() * motion.translation);
    }
  }
  camera.travel = FitTravelPrior(directions);
  camera.own_vehicle = ProveOwnVehicle(fixed, pairs, learnt, options.own_vehicle);
  if (camera.travel.IsKnown()) {
    camera.travel.direction = SharpenedDirection(camera.travel, worlds, camera.focal_ratio,
                                                 United(options.ignored, camera.own_vehicle));
  }
  return camera;
}

}  // namespace egosieve::vision
