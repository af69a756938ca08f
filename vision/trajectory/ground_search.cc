#include "vision/trajectory/ground_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "vision/frame/ignored_area.h"
#include "vision/image/bilinear.h"
#include "vision/image/cell_grid.h"
#include "vision/statistics/order_statistics.h"
#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

constexpr double kLeastBelow = 0.02;   // rays
constexpr double kAcross = 2.0;        // camera heights: about the own lane
constexpr double kStackSeconds = 0.2;  // pictures farther in time serve the fixed pattern only
constexpr double kChangeDeviations = 2.0;
constexpr double kNoiseFloor = 2.0;  // grey levels
constexpr double kNearest = 0.1;     // least depth, relative to that in the first picture
constexpr double kPixelCorrelation = 4.0, kMostOfCell = 6.0;
constexpr int kOwnMargin = 4;  // pixels around the ignored area
constexpr int kCellsAcross = 60, kSmallestCell = 8;

constexpr double kSlowerShare = 0.7, kFasterShare = 0.1;  // the rest: any speed
constexpr double kTowards = 0.5, kFastest = 3.0;          // of the ground's speed

constexpr size_t kMostPlaces = 1500;
// Two pictures less their mean are each other's negatives: where they move by less than the size of
// the texture they seem to disagree, and the greatest speed is found.
constexpr size_t kFewestPictures = 3;

// Speeds of objects other than the road: those of the ground, and these, in heights per second.
constexpr std::array kOtherSpeeds = {-20.0, -12.0, -6.0, -3.0, -1.5};
constexpr int kAllSpeeds = kSpeeds + static_cast<int>(kOtherSpeeds.size());
using AllSpeeds = Eigen::Array<double, kAllSpeeds, 1>;

AllSpeeds SpeedsTried() {
  AllSpeeds speeds;
  int k = 0;
  for (const double speed : kOtherSpeeds) speeds(k++) = speed;
  for (int i = 0; i < kSpeeds; ++i) speeds(k++) = SpeedAt(i);
  return speeds;
}

// p(v' | v) of (SR3): one row per speed of the ground.
using OtherPrior = Eigen::Matrix<double, kSpeeds, kAllSpeeds>;

OtherPrior MakeOtherPrior() {
  const AllSpeeds speeds = SpeedsTried();
  OtherPrior prior;
  for (int v = 0; v < kSpeeds; ++v) {
    const double ground = std::max(SpeedAt(v), kSlowSpeed);
    for (int k = 0; k < kAllSpeeds; ++k) {
      const double speed = speeds(k);
      const double width =
          0.5 * (speeds(std::min(k + 1, kAllSpeeds - 1)) - speeds(std::max(k - 1, 0)));
      double density = 0.0;
      if (speed >= -kTowards * ground && speed <= ground) {
        density = kSlowerShare / ((1.0 + kTowards) * ground);
      } else if (speed > ground && speed < kFastest * ground) {
        density = kFasterShare / ((kFastest - 1.0) * ground);
      }
      prior(v, k) = density * width + (1.0 - kSlowerShare - kFasterShare) / kAllSpeeds;
    }
    prior.row(v) /= prior.row(v).sum();
  }
  return prior;
}

constexpr double kNought = 128.0;  // grey level of a zero change in changes_

// a_k, with kNought added.
std::vector<cv::Mat> WithoutFixed(const std::vector<GroundPicture>& pictures) {
  cv::Mat1f mean(pictures[0].grey.size(), 0.0f);
  for (const GroundPicture& picture : pictures) cv::accumulate(picture.grey, mean);
  mean /= static_cast<double>(pictures.size());
  std::vector<cv::Mat> changes;
  for (const GroundPicture& picture : pictures) {
    cv::Mat change;
    cv::subtract(picture.grey, mean, change, cv::noArray(), CV_32F);
    change.convertTo(changes.emplace_back(), CV_8U, 1.0, kNought);
  }
  return changes;
}

// Sums of a cell at each speed: squares of the values, and squares about the means of the points.
struct CellSums {
  AllSpeeds squares = AllSpeeds::Zero(), about_means = AllSpeeds::Zero();
  AllSpeeds values = AllSpeeds::Zero(), places = AllSpeeds::Zero();

  // (SR2)
  AllSpeeds LogRatios(double noise_variance) const {
    const AllSpeeds all = squares / values.max(1.0) + noise_variance;
    const AllSpeeds about = about_means / (values - places).max(1.0) + noise_variance;
    return -0.5 / kPixelCorrelation * values * (about / all).log();
  }
};

// Points of the road's area in the first picture that differ from the fixed pattern, selected evenly.
// first: its changes. noise: set to theirs, grey levels.
std::vector<cv::Point> FindPlaces(const GroundSearchView& view, const cv::Mat& first,
                                  double& noise) {
  cv::Mat1b ignored;
  if (!view.ignored.empty()) {
    const int side = 2 * kOwnMargin + 1;
    cv::dilate(view.ignored, ignored, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  }
  const Eigen::Vector3d ahead = view.direction / view.direction(2);
  std::vector<cv::Point> area;
  std::vector<double> sizes;
  for (int y = 0; y < first.rows; ++y) {
    const double below = view.camera.Ray(0, y)(1) - ahead(1);
    if (below < kLeastBelow) continue;
    for (int x = 0; x < first.cols; ++x) {
      const Eigen::Vector3d ray = view.camera.Ray(x, y);
      if (std::abs(ray(0) - ahead(0)) > kAcross * below) continue;
      if (IsIgnored(ignored, first.size(), x, y)) continue;
      area.emplace_back(x, y);
      sizes.push_back(std::abs(first.at<uint8_t>(y, x) - kNought));
    }
  }
  noise = RobustScale(sizes, kNoiseFloor);
  std::vector<cv::Point> changed;
  for (size_t i = 0; i < area.size(); ++i) {
    if (sizes[i] > kChangeDeviations * noise) changed.push_back(area[i]);
  }
  const size_t count = std::min(changed.size(), kMostPlaces);
  std::vector<cv::Point> places;
  for (size_t k = 0; k < count; ++k) places.push_back(changed[k * changed.size() / count]);
  return places;
}

// Adds the sums over the pictures of one point at each speed.
void AddPlace(const GroundSearchView& view, const std::vector<cv::Mat>& changes, cv::Point place,
              const AllSpeeds& speeds, CellSums& sums) {
  const Eigen::Vector3d& direction = view.direction;
  const Eigen::Vector3d ray = view.camera.Ray(place.x, place.y);
  const double below = std::max(0.0, ray(1) - direction(1) / direction(2));
  AllSpeeds sum = AllSpeeds::Zero(), squares = AllSpeeds::Zero(), count = AllSpeeds::Zero();
  for (size_t k = 0; k < changes.size(); ++k) {
    const GroundPicture& picture = view.pictures[k];
    if (std::abs(picture.seconds) > kStackSeconds) continue;
    // The point in the picture's camera is still + speed * moved.
    const Eigen::Vector3d still = picture.rotation * ray,
                          moved = picture.rotation * (below * picture.seconds * direction);
    const AllSpeeds depth = still(2) + speeds * moved(2);
    const double f = view.camera.focal_pixels;
    const AllSpeeds x = view.camera.centre_x + f * (still(0) + speeds * moved(0)) / depth;
    const AllSpeeds y = view.camera.centre_y + f * (still(1) + speeds * moved(1)) / depth;
    for (int v = 0; v < kAllSpeeds; ++v) {
      if (!(depth(v) > kNearest)) continue;
      const double change = SampleOrNan(changes[k], x(v), y(v)) - kNought;
      if (std::isnan(change)) continue;
      sum(v) += change;
      squares(v) += change * change;
      count(v) += 1.0;
    }
  }
  for (int v = 0; v < kAllSpeeds; ++v) {
    if (count(v) < 2.0) continue;
    sums.squares(v) += squares(v);
    sums.about_means(v) += squares(v) - sum(v) * sum(v) / count(v);
    sums.values(v) += count(v);
    sums.places(v) += 1.0;
  }
}

}  // namespace

Eigen::Matrix3d PartOfRotation(const Eigen::Matrix3d& rotation, double share) {
  const Eigen::AngleAxisd turn(rotation);
  return Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
}

SpeedLikelihood LikelihoodOfSpeeds(const GroundSearchView& view) {
  SpeedLikelihood result{};
  if (!MovesForwardOrBack(view.direction) || view.pictures.size() < kFewestPictures) return result;
  const std::vector<cv::Mat> changes = WithoutFixed(view.pictures);
  double noise = 0.0;
  const std::vector<cv::Point> places = FindPlaces(view, changes[0], noise);
  const cv::Size size = changes[0].size();
  const int side = std::max(kSmallestCell, std::max(size.width, size.height) / kCellsAcross);
  const AllSpeeds speeds = SpeedsTried();
  const SquareCells<int> grid = CellsOfPixels(size, side);
  std::map<size_t, CellSums> cells;
  for (const cv::Point place : places) {
    AddPlace(view, changes, place, speeds, cells[grid.IndexOf(place.x, place.y)]);
  }
  static const OtherPrior prior = MakeOtherPrior();
  for (const auto& [cell, sums] : cells) {
    AllSpeeds ratios = sums.LogRatios(noise * noise);
    const double best = ratios.maxCoeff();
    ratios = (ratios - best).max(-kMostOfCell).exp();
    const Eigen::Array<double, kSpeeds, 1> other = (prior * ratios.matrix()).array();
    for (int v = 0; v < kSpeeds; ++v) {
      result[v] += best + std::log(0.5 * ratios(kOtherSpeeds.size() + v) + 0.5 * other(v));
    }
  }
  for (double& value : result) value /= static_cast<double>(view.pictures.size());
  return result;
}

}  // namespace egosieve::vision
