#include "vision/trajectory/ground_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "vision/evidence/patch.h"
#include "vision/frame/ignored_area.h"
#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

constexpr double kLeastBelow = 0.02;  // rays
constexpr double kAcross = 2.0;       // camera heights: about the lane that is driven in
constexpr double kLeastChange = 6.0, kLeastContrast = 4.0;  // grey levels; contrast per pixel
constexpr double kChangeDeviations = 4.0, kContrastDeviations = 1.5;
constexpr double kNoiseFloor = 2.0;        // of s, grey levels
constexpr double kMisplacedPixels = 0.25;  // of a place on the road
constexpr double kMatchShare = 0.8, kUniformShare = 0.05;
constexpr double kHistogramDeviation = 4.0;  // grey levels
constexpr double kPixelCorrelation = 4.0, kMostOfCell = 6.0;
constexpr int kOwnMargin = 4;  // pixels around what is ignored
constexpr int kCellsAcross = 60, kSmallestCell = 8;
constexpr size_t kMostPixels = 2500;

// Speeds of what is not the road: the ground's, and these, heights per second.
constexpr std::array kOtherSpeeds = {-20.0, -12.0, -6.0, -3.0, -1.5, 0.0, 0.3};
constexpr int kAllSpeeds = kSpeeds + static_cast<int>(kOtherSpeeds.size());
constexpr double kSlowerShare = 0.7, kFasterShare = 0.1;  // the rest has any speed
constexpr double kTowards = 0.5, kFastest = 3.0;          // of the ground's speed

using AllSpeeds = Eigen::Array<double, kAllSpeeds, 1>;

AllSpeeds SpeedsTried() {
  AllSpeeds speeds;
  int k = 0;
  for (const double speed : kOtherSpeeds) speeds(k++) = speed;
  for (int i = 0; i < kSpeeds; ++i) speeds(k++) = SpeedAt(i);
  return speeds;
}

// p(g' | v) of (SR3): a row a speed of the ground, the last without ground.
using OtherPrior = Eigen::Matrix<double, kSpeeds + 1, kAllSpeeds>;

OtherPrior MakeOtherPrior() {
  const AllSpeeds speeds = SpeedsTried();
  OtherPrior prior;
  for (int v = 0; v < kSpeeds; ++v) {
    const double ground = SpeedAt(v);
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
  prior.row(kSpeeds).setConstant(1.0 / kAllSpeeds);
  return prior;
}

// A pixel of the road's area that changed.
struct Pixel {
  cv::Point at;
  double below = 0.0;  // p_y - h, rays
  double value = 0.0, deviation = 0.0;
};

class Search {
 public:
  explicit Search(const GroundSearchView& view)
      : view_(view),
        travel_x_(view.direction(0) / view.direction(2)),
        horizon_(view.direction(1) / view.direction(2)),
        cell_(std::max(kSmallestCell, std::max(view.now.cols, view.now.rows) / kCellsAcross)) {
    FindArea();
    if (differences_.empty()) return;
    FindPixels();
  }

  SpeedLikelihood Likelihood() const {
    SpeedLikelihood result{};
    if (pixels_.empty()) return result;
    static const OtherPrior prior = MakeOtherPrior();
    for (AllSpeeds& ratios : CellRatios()) {
      ratios = (ratios - ratios.maxCoeff()).max(-kMostOfCell).exp();
      const Eigen::Array<double, kSpeeds + 1, 1> other = (prior * ratios.matrix()).array();
      for (int v = 0; v < kSpeeds; ++v) {
        result[v] += std::log(0.5 * ratios(kOtherSpeeds.size() + v) + 0.5 * other(v));
      }
      result[kSpeeds] += std::log(other(kSpeeds));
    }
    return result;
  }

 private:
  // Grey level in the picture before of a ray moved by r, NaN outside.
  float Before(const Eigen::Vector3d& ray, double r) const {
    const Eigen::Vector2d there =
        view_.camera.Project(view_.rotation * (ray + r * view_.direction));
    return SampleAt(view_.before, there(0), there(1));
  }

  // The road's area, what changed there by the rotation alone, and its noise.
  void FindArea() {
    cv::Mat1b ignored;
    if (!view_.ignored.empty()) {
      const int side = 2 * kOwnMargin + 1;
      cv::dilate(view_.ignored, ignored, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
    }
    std::array<double, 256> counts{};
    std::vector<float> sizes;
    for (int y = 0; y < view_.now.rows; ++y) {
      const double below = view_.camera.Ray(0, y)(1) - horizon_;
      if (below < kLeastBelow) continue;
      for (int x = 0; x < view_.now.cols; ++x) {
        const Eigen::Vector3d ray = view_.camera.Ray(x, y);
        if (std::abs(ray(0) - travel_x_) > kAcross * below) continue;
        if (IsIgnored(ignored, view_.now.size(), x, y)) continue;
        const float before = Before(ray, 0.0);
        if (std::isnan(before)) continue;
        ++counts[static_cast<int>(before)];
        const float difference = std::abs(view_.now.at<uint8_t>(y, x) - before);
        differences_.push_back({{x, y}, below, difference, 0.0});
        sizes.push_back(difference);
      }
    }
    if (differences_.empty()) return;
    std::nth_element(sizes.begin(), sizes.begin() + sizes.size() / 2, sizes.end());
    noise_ = 1.4826 * sizes[sizes.size() / 2];
    SmoothHistogram(counts);
  }

  void SmoothHistogram(const std::array<double, 256>& counts) {
    for (int level = 0; level < 256; ++level) {
      double sum = 0.0, weights = 0.0;
      for (int other = 0; other < 256; ++other) {
        const double z = (other - level) / kHistogramDeviation;
        const double weight = std::exp(-0.5 * z * z);
        weights += weight;
        sum += weight * counts[other];
      }
      chance_[level] =
          (1.0 - kUniformShare) * sum / (weights * static_cast<double>(differences_.size())) +
          kUniformShare / 256.0;
    }
  }

  void FindPixels() {
    cv::Mat across, down, contrast, near;
    cv::Sobel(view_.now, across, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(view_.now, down, CV_32F, 0, 1, 3, 0.125);
    cv::magnitude(across, down, contrast);
    cv::dilate(contrast, near, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
    const double least_change = std::max(kLeastChange, kChangeDeviations * noise_);
    const double least_contrast = std::max(kLeastContrast, kContrastDeviations * noise_);
    std::vector<Pixel> changed;
    for (Pixel pixel : differences_) {
      if (pixel.value <= least_change || near.at<float>(pixel.at) <= least_contrast) continue;
      pixel.value = view_.now.at<uint8_t>(pixel.at);
      pixel.deviation =
          std::hypot(2.0 * noise_ + kNoiseFloor, kMisplacedPixels * contrast.at<float>(pixel.at));
      changed.push_back(pixel);
    }
    const size_t count = std::min(changed.size(), kMostPixels);
    for (size_t k = 0; k < count; ++k) pixels_.push_back(changed[k * changed.size() / count]);
  }

  // l_C of every cell.
  std::vector<AllSpeeds> CellRatios() const {
    const AllSpeeds slopes = SpeedsTried() * view_.seconds;
    std::map<std::pair<int, int>, size_t> cells;
    std::vector<AllSpeeds> ratios;
    for (const Pixel& pixel : pixels_) {
      const auto [cell, is_new] =
          cells.try_emplace({pixel.at.y / cell_, pixel.at.x / cell_}, ratios.size());
      if (is_new) ratios.push_back(AllSpeeds::Zero());
      AllSpeeds& ratio = ratios[cell->second];
      const Eigen::Vector3d ray = view_.camera.Ray(pixel.at.x, pixel.at.y);
      const double peak = kMatchShare / (pixel.deviation * std::sqrt(2.0 * std::numbers::pi) *
                                         chance_[static_cast<int>(pixel.value)]);
      for (int k = 0; k < kAllSpeeds; ++k) {
        const float before = Before(ray, std::max(slopes(k) * pixel.below, kNearest));
        if (std::isnan(before)) continue;
        const double z = (pixel.value - before) / pixel.deviation;
        ratio(k) += std::log(peak * std::exp(-0.5 * z * z) + 1.0 - kMatchShare) / kPixelCorrelation;
      }
    }
    return ratios;
  }

  static constexpr double kNearest = -0.6;  // of r

  const GroundSearchView& view_;
  const double travel_x_, horizon_;
  const int cell_;                  // pixels
  std::vector<Pixel> differences_;  // `value`: by how much the place changed
  std::vector<Pixel> pixels_;
  std::array<double, 256> chance_{};
  double noise_ = 0.0;
};

}  // namespace

SpeedLikelihood LikelihoodOfSpeeds(const GroundSearchView& view) {
  if (!MovesForwardOrBack(view.direction)) return {};
  return Search(view).Likelihood();
}

}  // namespace egosieve::vision
