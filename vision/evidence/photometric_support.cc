#include "vision/evidence/photometric_support.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "vision/evidence/for_each_point.h"
#include "vision/evidence/patch.h"
#include "vision/statistics/order_statistics.h"

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
constexpr size_t kFewest = 20;  // least number of places for a median

// A row of a patch, padded to fill a vector register. What the last lane holds is not read.
constexpr int kLanes = kPatchSide + 1;
using Lanes = Eigen::Array<float, kLanes, 1>;
using Rows = std::array<Lanes, kPatchSide>;

Lanes LevelsFrom(const uint8_t* pixels) {
  Lanes levels;
  for (int x = 0; x < kLanes; ++x) levels[x] = pixels[x];
  return levels;
}

// The rows of the patch around a place, by (BI2) of bilinear.h in vectors. False if it leaves the
// picture.
bool SampleRows(const cv::Mat& picture, cv::Point2f place, Rows& rows) {
  const float left = place.x - kPatchRadius, top = place.y - kPatchRadius;
  if (!(left >= 0 && top >= 0 && left + kPatchSide < picture.cols &&
        top + kPatchSide < picture.rows)) {
    return false;
  }
  const int column = static_cast<int>(left), row = static_cast<int>(top);
  const float fx = left - column, fy = top - row;
  const auto between_columns = [&](int y) -> Lanes {
    const uint8_t* pixels = picture.ptr<uint8_t>(row + y) + column;
    uint8_t last[kLanes + 1] = {};  // at the right border there is no pixel after the lanes
    if (column + kLanes >= picture.cols) {
      std::copy_n(pixels, kLanes, last);
      pixels = last;
    }
    const Lanes at = LevelsFrom(pixels);
    return at + fx * (LevelsFrom(pixels + 1) - at);
  };
  Lanes above = between_columns(0);
  for (int y = 0; y < kPatchSide; ++y) {
    const Lanes below = between_columns(y + 1);
    rows[y] = above + fy * (below - above);
    above = below;
  }
  return true;
}

// Positions of a patch's pixels along one axis.
struct ScaledAxis {
  std::array<int, kPatchSide> first;  // the whole pixel before each position
  Lanes beyond = Lanes::Zero();       // distance from `first`
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

// SampleRows of a patch that is `scale` times as large.
bool SampleScaledRows(const cv::Mat& picture, cv::Point2f place, double scale, Rows& rows) {
  if (std::abs(scale - 1.0) < kLeastScaling) return SampleRows(picture, place, rows);
  ScaledAxis x, y;
  if (!MakeAxis(place.x, scale, picture.cols, x) || !MakeAxis(place.y, scale, picture.rows, y)) {
    return false;
  }
  const auto between_columns = [&](int row) -> Lanes {
    const uint8_t* pixels = picture.ptr<uint8_t>(row);
    Lanes left = Lanes::Zero(), right = Lanes::Zero();
    for (int u = 0; u < kPatchSide; ++u) {
      left[u] = pixels[x.first[u]];
      right[u] = pixels[x.first[u] + 1];
    }
    return left + x.beyond * (right - left);
  };
  // Neighbouring rows of the patch reuse interpolated rows of the picture.
  Lanes above, below;
  for (int v = 0; v < kPatchSide; ++v) {
    const int row = y.first[v], moved = v > 0 ? row - y.first[v - 1] : kPatchSide;
    if (moved == 1) {
      above = below;
    } else if (moved != 0) {
      above = between_columns(row);
    }
    if (moved != 0) below = between_columns(row + 1);
    rows[v] = above + y.beyond[v] * (below - above);
  }
  return true;
}

// Squared difference of two patches less their means, by the sums of the differences and of their
// squares: the levels of patches that match differ by little, so little is lost in the difference.
double SquaredDifference(const Rows& a, const Rows& b) {
  Lanes sums = Lanes::Zero(), squares = Lanes::Zero();
  for (int y = 0; y < kPatchSide; ++y) {
    const Lanes apart = a[y] - b[y];
    sums += apart;
    squares += apart * apart;
  }
  const double sum = sums.head<kPatchSide>().sum();
  return std::max(0.0, squares.head<kPatchSide>().sum() - sum * sum / kPatchPixels);
}

// Mean square of the gradient, by central differences inside the patch; (grey levels per pixel)^2.
double SquaredGradient(const Rows& rows) {
  constexpr int kInner = kPatchSide - 2;
  double sum = 0.0;
  for (int y = 1; y <= kInner; ++y) {
    const auto across = rows[y].segment<kInner>(2) - rows[y].segment<kInner>(0);
    const auto down = rows[y + 1].segment<kInner>(1) - rows[y - 1].segment<kInner>(1);
    sum += 0.25 * (across.square() + down.square()).sum();
  }
  return sum / (kInner * kInner);
}

// The step k of 0 to `steps` along `way` that is nearest to `place`, seen from the first one.
int NearestStep(cv::Point2f place, cv::Point2f way, int steps) {
  const double length = way.dot(way);
  if (!(length > 0.0)) return 0;
  return static_cast<int>(std::lround(std::clamp(place.dot(way) / length, 0.0, 1.0) * steps));
}

}  // namespace

PhotometricSupport::PhotometricSupport(cv::Mat before, cv::Mat now,
                                       const std::vector<cv::Point2f>& befores,
                                       const std::vector<cv::Point2f>& nows, double place_pixels)
    : before_(std::move(before)), now_(std::move(now)), place_pixels_(place_pixels) {
  std::vector<double> apart(befores.size(), -1.0);
  ForEachPoint(befores.size(), [&](size_t i) {
    Rows p, q;
    if (!SampleRows(before_, befores[i], p) || !SampleRows(now_, nows[i], q)) return;
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
  noise_levels_ = std::max(noise_levels_, MedianInPlace(levels));
}

double PhotometricSupport::LeastDifference() const {
  return kPatchPixels * noise_levels_ * noise_levels_;
}

double PhotometricSupport::RatioOf(double still, double found, double place_variance) const {
  const double least = LeastDifference();
  still = std::max(still, least);
  found = std::max(found, least);
  const double variance = std::min(found, still) / kPatchPixels;
  return kIndependentShare * (still - found) / (2.0 * (variance + place_variance));
}

std::optional<double> PhotometricSupport::LogRatio(cv::Point2f before, cv::Point2f now,
                                                   cv::Point2f standing) const {
  Rows p, q, s;
  if (!SampleRows(before_, before, p) || !SampleRows(now_, now, q) ||
      !SampleRows(now_, standing, s)) {
    return std::nullopt;
  }
  return RatioOf(SquaredDifference(p, s), SquaredDifference(p, q), 0.0);
}

std::optional<double> PhotometricSupport::LogRatioOnSegment(cv::Point2f before, cv::Point2f now,
                                                            const StaticSegment& segment) const {
  Rows p, q, s;
  if (!SampleRows(before_, before, p) || !SampleRows(now_, now, q)) return std::nullopt;
  const double found = SquaredDifference(p, q);
  const double place_variance = place_pixels_ * place_pixels_ * SquaredGradient(p);
  const cv::Point2f way = segment.last - segment.first;
  const int steps = std::clamp(
      static_cast<int>(std::ceil(kStepsPerPixel * std::hypot(way.x, way.y))), 1, kMostSteps);
  // The ratio grows with E_0, so the least E_0 gives the least ratio. It is 0 from `enough` on, which
  // is likely near the found position: outwards from there the search ends early.
  const double enough = std::max(found, LeastDifference());
  double still = std::numeric_limits<double>::infinity();
  const auto measure = [&](int k) {
    if (k < 0 || k > steps || still <= enough) return;
    const float share = static_cast<float>(k) / static_cast<float>(steps);
    const double scale = std::lerp(segment.scale_first, segment.scale_last, share);
    if (SampleScaledRows(now_, segment.first + share * way, scale, s)) {
      still = std::min(still, SquaredDifference(p, s));
    }
  };
  const int nearest = NearestStep(now - segment.first, way, steps);
  measure(nearest);
  for (int apart = 1; apart <= steps && still > enough; ++apart) {
    measure(nearest + apart);
    measure(nearest - apart);
  }
  if (std::isinf(still)) return std::nullopt;
  return std::max(0.0, RatioOf(still, found, place_variance));
}

}  // namespace egosieve::vision
