#include "vision/evidence/photometric_support.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "vision/evidence/patch.h"

namespace egosieve::vision {
namespace {

constexpr double kNoiseFloorLevels = 1.5;
constexpr double kIndependentShare = 0.25;  // kappa
constexpr double kStepsPerPixel = 2.0;
constexpr int kMostSteps = 400;
// Two patches that differ by less are no two exposures: half a grey level each is rounding alone.
constexpr double kCopyLevels = 0.7;
constexpr size_t kFewestFresh = 20;
constexpr double kLeastScaling = 0.05;  // a sixth of a pixel at the patch's edge

// The patch around a place, sampled bilinearly, less its mean. False where it leaves the picture.
bool Sample(const cv::Mat& picture, cv::Point2f place, Patch& patch) {
  const float left = place.x - kPatchRadius, top = place.y - kPatchRadius;
  if (!(left >= 0 && top >= 0 && left + kPatchSide < picture.cols &&
        top + kPatchSide < picture.rows)) {
    return false;
  }
  const int column = static_cast<int>(left), row = static_cast<int>(top);
  const float fx = left - column, fy = top - row;
  for (int y = 0; y < kPatchSide; ++y) {
    const uint8_t* upper = picture.ptr<uint8_t>(row + y) + column;
    const uint8_t* lower = picture.ptr<uint8_t>(row + y + 1) + column;
    for (int x = 0; x < kPatchSide; ++x) {
      const float above = upper[x] + fx * (upper[x + 1] - upper[x]);
      const float below = lower[x] + fx * (lower[x + 1] - lower[x]);
      patch[y * kPatchSide + x] = above + fy * (below - above);
    }
  }
  SubtractMean(patch);
  return true;
}

// The same of a patch that is `scale` times as large.
bool SampleScaled(const cv::Mat& picture, cv::Point2f place, double scale, Patch& patch) {
  if (std::abs(scale - 1.0) < kLeastScaling) return Sample(picture, place, patch);
  patch = TakeMoved<kPatchRadius, kPatchRadius>(
      picture, 0.0, 0.0, [&](const Eigen::Vector2d& offset) -> Eigen::Vector2d {
        return Eigen::Vector2d(place.x, place.y) + scale * offset;
      });
  return std::isfinite(SubtractMean(patch));
}

// Mean square of the gradient, central differences inside the patch; per pixel^2.
double SquaredGradient(const Patch& patch) {
  double sum = 0.0;
  for (int y = 1; y + 1 < kPatchSide; ++y) {
    for (int x = 1; x + 1 < kPatchSide; ++x) {
      const int i = y * kPatchSide + x;
      const float across = 0.5f * (patch[i + 1] - patch[i - 1]);
      const float down = 0.5f * (patch[i + kPatchSide] - patch[i - kPatchSide]);
      sum += across * across + down * down;
    }
  }
  return sum / ((kPatchSide - 2) * (kPatchSide - 2));
}

}  // namespace

PhotometricSupport::PhotometricSupport(cv::Mat before, cv::Mat now,
                                       const std::vector<cv::Point2f>& befores,
                                       const std::vector<cv::Point2f>& nows, double place_pixels)
    : before_(std::move(before)), now_(std::move(now)), place_pixels_(place_pixels) {
  std::vector<double> all, fresh;
  Patch p, q;
  for (size_t i = 0; i < befores.size(); ++i) {
    if (!Sample(before_, befores[i], p) || !Sample(now_, nows[i], q)) continue;
    all.push_back(std::sqrt(SquaredDifference(p, q) / kPatchPixels));
    if (all.back() >= kCopyLevels) fresh.push_back(all.back());
  }
  noise_levels_ = kNoiseFloorLevels;
  std::vector<double>& levels = fresh.size() >= kFewestFresh ? fresh : all;
  if (levels.empty()) return;
  const auto middle = levels.begin() + static_cast<int64_t>(levels.size() / 2);
  std::nth_element(levels.begin(), middle, levels.end());
  noise_levels_ = std::max(noise_levels_, *middle);
}

std::optional<double> PhotometricSupport::LogRatio(cv::Point2f before, cv::Point2f now,
                                                   cv::Point2f standing) const {
  const std::optional<double> ratio = SignedLogRatio(before, now, standing);
  return ratio ? std::max(0.0, *ratio) : ratio;
}

double PhotometricSupport::RatioOf(double still, double found, double place_variance) const {
  const double variance =
      std::max(noise_levels_ * noise_levels_, std::min(found, still) / kPatchPixels);
  return kIndependentShare * (still - found) / (2.0 * (variance + place_variance));
}

std::optional<double> PhotometricSupport::SignedLogRatio(cv::Point2f before, cv::Point2f now,
                                                         cv::Point2f standing) const {
  Patch p, q, s;
  if (!Sample(before_, before, p) || !Sample(now_, now, q) || !Sample(now_, standing, s)) {
    return std::nullopt;
  }
  return RatioOf(SquaredDifference(p, s), SquaredDifference(p, q), 0.0);
}

std::optional<double> PhotometricSupport::LogRatioOnSegment(cv::Point2f before, cv::Point2f now,
                                                            const StaticSegment& segment) const {
  Patch p, q, s;
  if (!Sample(before_, before, p) || !Sample(now_, now, q)) return std::nullopt;
  const double found = SquaredDifference(p, q);
  const double place_variance = place_pixels_ * place_pixels_ * SquaredGradient(p);
  const cv::Point2f way = segment.last - segment.first;
  const int steps = std::clamp(
      static_cast<int>(std::ceil(kStepsPerPixel * std::hypot(way.x, way.y))), 1, kMostSteps);
  std::optional<double> least;
  for (int k = 0; k <= steps && !(least && *least <= 0.0); ++k) {
    const float share = static_cast<float>(k) / static_cast<float>(steps);
    const double scale = std::lerp(segment.scale_first, segment.scale_last, share);
    if (!SampleScaled(now_, segment.first + share * way, scale, s)) continue;
    const double ratio = RatioOf(SquaredDifference(p, s), found, place_variance);
    least = std::min(ratio, least.value_or(ratio));
  }
  return least ? std::max(0.0, *least) : least;
}

}  // namespace egosieve::vision
