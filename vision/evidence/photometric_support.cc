#include "vision/evidence/photometric_support.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "vision/evidence/for_each_point.h"
#include "vision/evidence/patch.h"

namespace egosieve::vision {
namespace {

constexpr double kNoiseFloorLevels = 1.5;
constexpr double kIndependentShare = 0.25;  // kappa
constexpr double kStepsPerPixel = 2.0;
constexpr int kMostSteps = 400;
// Patches that differ by less are copies, not two exposures: rounding alone adds up to half a grey
// level to each.
constexpr double kCopyLevels = 0.7;
constexpr double kMovedPixels = 1.0;
constexpr size_t kFewest = 20;          // least number of places for a median
constexpr double kLeastScaling = 0.05;  // a sixth of a pixel at the patch's edge

constexpr int kLanes = kPatchSide + 1;  // a patch's row, padded to fill a vector register

// The patch around a place, sampled bilinearly. False if it leaves the picture.
bool SampleLevels(const cv::Mat& picture, cv::Point2f place, Patch& patch) {
  const float left = place.x - kPatchRadius, top = place.y - kPatchRadius;
  if (!(left >= 0 && top >= 0 && left + kPatchSide < picture.cols &&
        top + kPatchSide < picture.rows)) {
    return false;
  }
  const int column = static_cast<int>(left), row = static_cast<int>(top);
  const float fx = left - column, fy = top - row;
  const auto between_columns = [&](int y, float* levels) {
    const uint8_t* pixels = picture.ptr<uint8_t>(row + y) + column;
    float at[kLanes + 1] = {};
    for (int x = 0; x < kLanes; ++x) at[x] = pixels[x];
    for (int x = 0; x < kLanes; ++x) levels[x] = at[x] + fx * (at[x + 1] - at[x]);
  };
  float above[kLanes], below[kLanes];
  between_columns(0, above);
  for (int y = 0; y < kPatchSide; ++y) {
    between_columns(y + 1, below);
    for (int x = 0; x < kLanes; ++x) above[x] = above[x] + fy * (below[x] - above[x]);
    std::copy_n(above, kPatchSide, &patch[y * kPatchSide]);
    std::copy_n(below, kLanes, above);
  }
  return true;
}

bool Sample(const cv::Mat& picture, cv::Point2f place, Patch& patch) {
  if (!SampleLevels(picture, place, patch)) return false;
  SubtractMean(patch);
  return true;
}

// Positions of a patch's pixels along one axis.
struct ScaledAxis {
  std::array<int, kPatchSide> first;   // the whole pixel before each position
  std::array<float, kLanes> beyond{};  // distance from `first`
};

// False if the patch leaves the picture.
bool MakeAxis(double centre, double scale, int size, ScaledAxis& axis) {
  for (int k = 0; k < kPatchSide; ++k) {
    const double at = centre + scale * (k - kPatchRadius);
    if (!(at >= 0 && at < size - 1)) return false;
    axis.first[k] = static_cast<int>(at);
    axis.beyond[k] = static_cast<float>(at - axis.first[k]);
  }
  return true;
}

// SampleLevels of a patch that is `scale` times as large.
bool SampleScaledLevels(const cv::Mat& picture, cv::Point2f place, double scale, Patch& patch) {
  if (std::abs(scale - 1.0) < kLeastScaling) return SampleLevels(picture, place, patch);
  ScaledAxis x, y;
  if (!MakeAxis(place.x, scale, picture.cols, x) || !MakeAxis(place.y, scale, picture.rows, y)) {
    return false;
  }
  const auto between_columns = [&](int row, std::array<float, kLanes>& levels) {
    const uint8_t* pixels = picture.ptr<uint8_t>(row);
    std::array<float, kLanes> left{}, right{};
    for (int u = 0; u < kPatchSide; ++u) {
      left[u] = pixels[x.first[u]];
      right[u] = pixels[x.first[u] + 1];
    }
    for (int u = 0; u < kLanes; ++u) levels[u] = left[u] + x.beyond[u] * (right[u] - left[u]);
  };
  // Neighbouring rows of the patch reuse interpolated rows of the picture.
  std::array<float, kLanes> above, below, levels;
  for (int v = 0; v < kPatchSide; ++v) {
    const int row = y.first[v], moved = v > 0 ? row - y.first[v - 1] : kPatchSide;
    if (moved == 1) {
      above = below;
    } else if (moved != 0) {
      between_columns(row, above);
    }
    if (moved != 0) between_columns(row + 1, below);
    for (int u = 0; u < kLanes; ++u) levels[u] = above[u] + y.beyond[v] * (below[u] - above[u]);
    std::copy_n(levels.begin(), kPatchSide, &patch[v * kPatchSide]);
  }
  return true;
}

// Patches stored side by side, so that one vector instruction processes the same pixel of all of
// them. In the sum over a single patch, each addition would have to wait for the one before.
class PatchBatch {
 public:
  static constexpr int kMost = 16;

  bool IsFull() const { return count_ == kMost; }
  void Add(const Patch& levels) {
    for (int i = 0; i < kPatchPixels; ++i) levels_[i][count_] = levels[i];
    ++count_;
  }
  // The least squared difference between `patch`, whose mean is 0, and the patches less their
  // means; infinite without patches.
  double LeastSquaredDifference(const Patch& patch) const {
    float means[kMost] = {}, sums[kMost] = {};
    for (int i = 0; i < kPatchPixels; ++i) {
      for (int k = 0; k < kMost; ++k) means[k] += levels_[i][k];
    }
    for (float& mean : means) mean /= kPatchPixels;
    for (int i = 0; i < kPatchPixels; ++i) {
      for (int k = 0; k < kMost; ++k) {
        const float apart = patch[i] - (levels_[i][k] - means[k]);
        sums[k] += apart * apart;
      }
    }
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < count_; ++k) least = std::min<double>(least, sums[k]);
    return least;
  }

 private:
  alignas(64) float levels_[kPatchPixels][kMost] = {};
  int count_ = 0;
};

// Mean square of the gradient, by central differences inside the patch; (grey levels per pixel)^2.
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
  std::vector<double> apart(befores.size(), -1.0);
  ForEachPoint(befores.size(), [&](size_t i) {
    Patch p, q;
    if (!Sample(before_, befores[i], p) || !Sample(now_, nows[i], q)) return;
    apart[i] = std::sqrt(SquaredDifference(p, q) / kPatchPixels);
  });
  std::vector<double> all, fresh, moved;
  for (size_t i = 0; i < apart.size(); ++i) {
    if (apart[i] >= 0.0) all.push_back(apart[i]);
    if (apart[i] < kCopyLevels) continue;
    fresh.push_back(apart[i]);
    if (cv::norm(nows[i] - befores[i]) >= kMovedPixels) moved.push_back(apart[i]);
  }
  noise_levels_ = kNoiseFloorLevels;
  std::vector<double>& levels =
      moved.size() >= kFewest ? moved : (fresh.size() >= kFewest ? fresh : all);
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
  const double least = kPatchPixels * noise_levels_ * noise_levels_;
  still = std::max(still, least);
  found = std::max(found, least);
  const double variance = std::min(found, still) / kPatchPixels;
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
  // The ratio grows with E_0, so the least E_0 gives the least ratio.
  double still = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= steps && still > found;) {
    PatchBatch batch;
    for (; k <= steps && !batch.IsFull(); ++k) {
      const float share = static_cast<float>(k) / static_cast<float>(steps);
      const double scale = std::lerp(segment.scale_first, segment.scale_last, share);
      if (SampleScaledLevels(now_, segment.first + share * way, scale, s)) batch.Add(s);
    }
    still = std::min(still, batch.LeastSquaredDifference(p));
  }
  if (std::isinf(still)) return std::nullopt;
  return std::max(0.0, RatioOf(still, found, place_variance));
}

}  // namespace egosieve::vision
