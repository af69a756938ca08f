#include "vision/own_vehicle/own_vehicle.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "vision/own_vehicle/mount_shake.h"
#include "vision/statistics/order_statistics.h"
#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

// Pixels of a patch of the own vehicle.
constexpr int kLeastArea = 2 * kFixedPatternWindow * kFixedPatternWindow;
constexpr double kShowingShare = 0.8;
constexpr double kChangingShare = 0.2;  // of pictures with contrast at a place that is not blank
constexpr int kClosing = 9;             // pixels: closes gaps, such as changing digits
constexpr double kLeastBelow = 0.03;    // rays; closer to the horizon the ground is too far away
constexpr size_t kFewestBelow = 20;     // points
// Of the direction of travel, radians. In steady pictures lane lines agree that would not otherwise.
constexpr double kTravelDeviation = 0.035;
constexpr double kGroundShare = 0.3;  // of (OV3): allows for traffic at equal speed, and hills
constexpr double kEnclosed = 0.6;     // share of own vehicle along the border of a blank part

// tau of two_view_motion.h: the translation in the first camera's coordinates.
Eigen::Vector3d TauOf(const TwoViewMotion& motion) {
  return motion.rotation.transpose() * motion.translation;
}

// The summand of (OV2) at a place of the original picture. scale: size of the reduced picture over
// the original; times: n_k; is_steady: w_k is 0.
double EvidenceOf(const PairWorld& world, double times, const Eigen::Vector2d& place,
                  const Eigen::Matrix2d& s, double scale, const Pinhole& camera, bool is_steady) {
  if (!world.motion.found) return 0.0;
  const Eigen::Vector3d ray = camera.Ray(place(0), place(1));
  const Eigen::Vector3d turned = world.motion.rotation * ray;
  if (!(turned(2) > 0.0)) return 0.0;
  const Eigen::Vector3d tau = TauOf(world.motion);
  Eigen::Vector2d w = scale * (camera.Project(turned) - place);
  if (is_steady) w.setZero();
  const Eigen::Vector2d e =
      times * scale * camera.focal_pixels * (tau.head<2>() - tau(2) * ray.head<2>());
  const double least = LeastInverseDepth(world.ground_slope, ray.head<2>(), tau);
  const double curvature = e.dot(s * e), slope = e.dot(s * w);
  const double r = curvature > 0.0 ? std::max(least, -slope / curvature) : least;
  const double cost = w.dot(s * w) + 2.0 * r * slope + r * r * curvature;
  const double deviation = is_steady ? kTravelDeviation : 0.0;
  const double sigma =
      std::hypot(kMostShiftPixels, deviation * times * scale * camera.focal_pixels * r);
  return std::min(kMostOfPair, 0.5 * cost / (sigma * sigma));
}

// Removes patches not much larger than the window, which may agree by chance.
void RemoveSmall(cv::Mat1b& own) {
  cv::Mat1i component, properties;
  cv::Mat1d centres;
  cv::connectedComponentsWithStats(own, component, properties, centres, 8, CV_32S);
  for (int y = 0; y < own.rows; ++y) {
    for (int x = 0; x < own.cols; ++x) {
      if (properties(component(y, x), cv::CC_STAT_AREA) < kLeastArea) own(y, x) = 0;
    }
  }
}

// Adds blank parts whose border is mostly own vehicle. The border of the image does not count.
void FillEnclosed(const cv::Mat1b& kind, cv::Mat1b& own) {
  cv::morphologyEx(own, own, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {kClosing, kClosing}));
  cv::Mat1b blank = (kind == FixedPlaces::kBlank) & (own == 0);
  cv::Mat1i component;
  const int count = cv::connectedComponents(blank, component, 4, CV_32S);
  std::vector<int64_t> around(count, 0), own_around(count, 0);
  for (int y = 0; y < own.rows; ++y) {
    for (int x = 0; x < own.cols; ++x) {
      for (const cv::Point step : {cv::Point(1, 0), cv::Point(0, 1)}) {
        const cv::Point a(x, y), b = a + step;
        if (b.x >= own.cols || b.y >= own.rows || component(a) == component(b)) continue;
        for (const auto& [inside, outside] : {std::pair(a, b), std::pair(b, a)}) {
          ++around[component(inside)];
          own_around[component(inside)] += own(outside) != 0;
        }
      }
    }
  }
  for (int y = 0; y < own.rows; ++y) {
    for (int x = 0; x < own.cols; ++x) {
      const int c = component(y, x);
      if (c == 0 || around[c] == 0) continue;
      if (static_cast<double>(own_around[c]) >= kEnclosed * static_cast<double>(around[c])) {
        own(y, x) = 255;
      }
    }
  }
}

std::vector<cv::Mat1f> Smooth(const std::vector<cv::Mat1b>& reduced) {
  std::vector<cv::Mat1f> pictures;
  for (const cv::Mat1b& picture : reduced) pictures.push_back(SmoothPicture(picture));
  return pictures;
}

// Tells candidates whose patch shifts from those that stay.
void FindShifting(const FixedPattern& pattern, const std::vector<cv::Mat1f>& pictures,
                  cv::Mat1b& kind) {
  cv::Mat1i component;
  const int count = cv::connectedComponents(kind == FixedPlaces::kFixed, component, 8, CV_32S);
  std::vector<std::vector<cv::Point>> patches(count);
  for (int y = 0; y < kind.rows; ++y) {
    for (int x = 0; x < kind.cols; ++x) {
      if (component(y, x) != 0) patches[component(y, x)].emplace_back(x, y);
    }
  }
  std::vector<std::vector<double>> shifts(count);
  for (const cv::Mat1f& picture : pictures) {
    const std::vector<cv::Vec2d> of_picture = pattern.Shifts(picture, patches);
    for (int c = 1; c < count; ++c) shifts[c].push_back(cv::norm(of_picture[c]));
  }
  for (int c = 1; c < count; ++c) {
    if (MedianInPlace(shifts[c]) <= kMostShiftPixels) continue;
    for (const cv::Point place : patches[c]) kind(place) = FixedPlaces::kShifting;
  }
}

// Step 1. is_steady: what a camera follows is not told from what shakes with its mount.
FixedPlaces FixedIn(const std::vector<cv::Mat1f>& pictures, cv::Size image, bool is_steady) {
  FixedPlaces places;
  places.image = image;
  const cv::Mat1f median = MedianPicture(pictures);
  const bool is_drive = pictures.size() >= kFewestOfDrive;
  if (is_drive) median.convertTo(places.median, CV_8U);
  const FixedPattern pattern(median);
  const cv::Size size = median.size();
  const double least_variance = kLeastContrast * kLeastContrast;
  cv::Mat1i showing = cv::Mat1i::zeros(size), contrasting = cv::Mat1i::zeros(size);
  for (const cv::Mat1f& picture : pictures) {
    if (is_drive) places.agreeing.push_back(pattern.Agreeing(picture));
    cv::add(showing, 1, showing, pattern.Showing(picture));
    cv::add(contrasting, 1, contrasting, VarianceInWindow(picture) >= least_variance);
  }
  const double count = static_cast<double>(pictures.size());
  places.kind = cv::Mat1b(size, FixedPlaces::kBlank);
  const cv::Mat1f trace = pattern.xx() + pattern.yy() + 1e-6F;
  places.s_xx = pattern.xx() / trace;
  places.s_xy = pattern.xy() / trace;
  places.s_yy = pattern.yy() / trace;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const bool shows = showing(y, x) >= kShowingShare * count;
      if (shows && pattern.variance()(y, x) >= least_variance) {
        places.kind(y, x) = FixedPlaces::kFixed;
      } else if (!shows && contrasting(y, x) >= kChangingShare * count) {
        places.kind(y, x) = FixedPlaces::kChanging;
      }
    }
  }
  if (!is_steady) FindShifting(pattern, pictures, places.kind);
  return places;
}

}  // namespace

double LeastGroundSlope(const std::vector<PointPair>& pairs, const TwoViewMotion& motion,
                        const Pinhole& camera) {
  if (!motion.HasParallax()) return 0.0;
  const Eigen::Vector3d tau = TauOf(motion);
  std::vector<double> slopes;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d ray = camera.Ray(pair.x1, pair.y1);
    const double below = Below(ray.head<2>(), tau);
    if (below < kLeastBelow) continue;
    const PairLikelihood likelihood = LikelihoodOf(motion, camera, pair);
    if (likelihood.log_static < likelihood.log_moving) continue;
    slopes.push_back(likelihood.along / (tau.head<2>() - tau(2) * ray.head<2>()).norm() / below);
  }
  if (slopes.size() < kFewestBelow) return 0.0;
  return kGroundShare * std::max(0.0, MedianInPlace(slopes));
}

bool FixedPlaces::IsFixed(double x, double y) const {
  if (kind.empty()) return false;
  const int column = static_cast<int>((x + 0.5) * kind.cols / image.width);
  const int row = static_cast<int>((y + 0.5) * kind.rows / image.height);
  return column >= 0 && row >= 0 && column < kind.cols && row < kind.rows &&
         kind(row, column) >= kShifting;
}

bool FixedPlaces::IsFixedIn(size_t picture, double x, double y) const {
  if (shakes.empty()) return IsFixed(x, y);
  const double scale = static_cast<double>(kind.cols) / image.width;
  const cv::Vec2d place =
      Steadied(shakes[picture], {scale * (x + 0.5) - 0.5, scale * (y + 0.5) - 0.5});
  return IsFixed((place(0) + 0.5) / scale - 0.5, (place(1) + 0.5) / scale - 0.5);
}

FixedPlaces FindFixedPlaces(const std::vector<cv::Mat1b>& reduced, cv::Size image) {
  if (reduced.size() >= kFewestPictures)
    return FixedIn(Smooth(reduced), image, /*is_steady=*/false);
  FixedPlaces none;
  none.image = image;
  return none;
}

FixedPlaces FindFixedOnMount(const std::vector<cv::Mat1b>& reduced, cv::Size image) {
  FixedPlaces places;
  places.image = image;
  if (reduced.size() < kFewestOfDrive) return places;
  SteadyPictures steady = SteadyOnMount(Smooth(reduced));
  if (TypicalShake(steady) <= kMostShiftPixels) return places;
  places = FixedIn(steady.pictures, image, /*is_steady=*/true);
  places.shakes = std::move(steady.shakes);
  return places;
}

cv::Mat1b OfTheImage(const cv::Mat1b& reduced, cv::Size image) {
  if (reduced.empty() || cv::countNonZero(reduced) == 0) return {};
  cv::Mat1b whole;
  cv::resize(reduced, whole, image, 0, 0, cv::INTER_NEAREST);
  return whole;
}

cv::Mat1b ProvenPlaces(const cv::Mat1b& candidates, const FixedPlaces& places,
                       const std::vector<PairWorld>& worlds, const Pinhole& camera,
                       const std::vector<cv::Mat1b>* both_agree) {
  const double scale = static_cast<double>(places.kind.cols) / places.image.width;
  cv::Mat1b proven = cv::Mat1b::zeros(candidates.size());
  for (int y = 0; y < proven.rows; ++y) {
    for (int x = 0; x < proven.cols; ++x) {
      if (candidates(y, x) == 0) continue;
      Eigen::Matrix2d s;
      s << places.s_xx(y, x), places.s_xy(y, x), places.s_xy(y, x), places.s_yy(y, x);
      const Eigen::Vector2d place((x + 0.5) / scale - 0.5, (y + 0.5) / scale - 0.5);
      double evidence = 0.0;
      for (const PairWorld& world : worlds) {
        if (both_agree != nullptr && (*both_agree)[world.picture](y, x) == 0) continue;
        const double times = both_agree != nullptr ? 1.0 : world.times;
        evidence += EvidenceOf(world, times, place, s, scale, camera, !places.shakes.empty());
      }
      if (evidence > kLeastProof) proven(y, x) = 255;
    }
  }
  return proven;
}

cv::Mat1b ProveOwnVehicle(const FixedPlaces& places, const std::vector<PairWorld>& worlds,
                          const Pinhole& camera) {
  if (places.kind.empty()) return {};
  cv::Mat1b own = ProvenPlaces(places.kind == FixedPlaces::kFixed, places, worlds, camera);
  RemoveSmall(own);
  if (cv::countNonZero(own) != 0) FillEnclosed(places.kind, own);
  if (!places.shakes.empty()) own = Shaken(own, places.shakes);
  return OfTheImage(own, places.image);
}

}  // namespace egosieve::vision
