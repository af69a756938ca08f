#include "vision/features/patch_search.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "kernels/base/parallel_for.h"

namespace egosieve::vision {
namespace {

// Pixels at half resolution. 48 displacements sideways fill vector registers.
constexpr int kSide = kFlowPatchSide, kLeft = 24, kUp = 10;
constexpr int kWide = 2 * kLeft, kHigh = 2 * kUp + 1;
constexpr int kBeside = 2;
constexpr double kMostOfOthers = 0.9, kMostOfSpread = 0.8;
constexpr int kNoise = kSide * kSide / 2;  // of E: half a grey level per pixel
// Pixels at full resolution.
constexpr int kMostSteps = 6;  // of an alignment
constexpr double kMostReturn = 0.25, kMostAligned = 3.0;
constexpr double kAlikeFloor = 1.0, kAlikeSlope = 0.05;
constexpr size_t kPlacesPerTask = 64;
constexpr int kNeighbourhood = 2, kFewestAlike = 2;  // places

using Differences = std::array<std::array<uint16_t, kWide>, kHigh>;

// E of (PA1) for the patch whose corner is (x, y): row r, column c is the displacement
// (c - kLeft, r - kUp). `padded` is the other picture with kLeft more columns on either side. False
// where the patch leaves its picture. E has its maximum where the displaced patch leaves the other
// picture.
bool Compare(const cv::Mat& from, const cv::Mat& padded, int x, int y, Differences& differences) {
  constexpr uint16_t kOutside = std::numeric_limits<uint16_t>::max();
  const int top = y - kUp;
  if (x < 0 || y < 0 || x + kSide > from.cols || y + kSide > from.rows) return false;
  const int begin = std::min(std::max(kLeft - x, 0), kWide);
  const int end = std::clamp(from.cols - kSide - x + kLeft + 1, begin, kWide);
  for (int r = 0; r < kHigh; ++r) {
    std::array<uint16_t, kWide>& sums = differences[r];
    if (top + r < 0 || top + r + kSide > padded.rows) {
      sums.fill(kOutside);
      continue;
    }
    std::array<uint16_t, kWide> row{};
    for (int v = 0; v < kSide; ++v) {
      const uint8_t* p = from.ptr<uint8_t>(y + v) + x;
      const uint8_t* q = padded.ptr<uint8_t>(top + r + v) + x;
      for (int u = 0; u < kSide; ++u) {
        const uint8_t level = p[u];
        for (int c = 0; c < kWide; ++c) {
          const uint8_t other = q[c + u];
          const uint8_t apart = other > level ? other - level : level - other;
          row[c] = static_cast<uint16_t>(row[c] + apart);
        }
      }
    }
    sums = row;
    std::fill(sums.begin(), sums.begin() + begin, kOutside);
    std::fill(sums.begin() + end, sums.end(), kOutside);
  }
  return true;
}

int SpreadOf(const cv::Mat& picture, int x, int y) {
  const cv::Mat patch = picture(cv::Rect(x, y, kSide, kSide));
  const int mean = static_cast<int>(cv::sum(patch)[0]) / (kSide * kSide);
  int spread = 0;
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) spread += std::abs(patch.at<uint8_t>(v, u) - mean);
  }
  return spread;
}

// The displacement that is distinct, for the patch whose corner is (x, y); nothing without one.
std::optional<cv::Point> DistinctDisplacement(const cv::Mat& from, const cv::Mat& padded, int x,
                                              int y) {
  Differences differences;
  if (!Compare(from, padded, x, y, differences)) return std::nullopt;
  int best = std::numeric_limits<int>::max(), row = 0, column = 0;
  for (int r = 0; r < kHigh; ++r) {
    const auto least = std::min_element(differences[r].begin(), differences[r].end());
    if (*least >= best) continue;
    best = *least;
    row = r;
    column = static_cast<int>(least - differences[r].begin());
  }
  if (best >= kMostOfSpread * SpreadOf(from, x, y)) return std::nullopt;
  for (int r = 0; r < kHigh; ++r) {
    for (int c = 0; c < kWide; ++c) {
      const bool is_beside = std::abs(r - row) <= kBeside && std::abs(c - column) <= kBeside;
      if (!is_beside && best + kNoise >= kMostOfOthers * differences[r][c]) return std::nullopt;
    }
  }
  return cv::Point(column - kLeft, row - kUp);
}

// Displacements of points from one picture to the other.
struct Ways {
  std::vector<size_t> owners;  // indices of the places
  std::vector<cv::Point2f> starts, ends;

  cv::Point2f Way(size_t k) const { return ends[k] - starts[k]; }
  void Keep(const std::vector<uint8_t>& kept) {
    size_t count = 0;
    for (size_t k = 0; k < owners.size(); ++k) {
      if (kept[k] == 0) continue;
      owners[count] = owners[k];
      starts[count] = starts[k];
      ends[count++] = ends[k];
    }
    owners.resize(count);
    starts.resize(count);
    ends.resize(count);
  }
};

cv::Mat Halved(const FlowPicture& picture) {
  cv::Mat half, levels;
  cv::resize(picture.Pixels(), half, {}, 0.5, 0.5, cv::INTER_AREA);
  half.convertTo(levels, CV_8U);
  return levels;
}

Ways CoarseWays(const FlowPicture& from, const FlowPicture& to,
                const std::vector<cv::Point2f>& places) {
  const cv::Mat half_from = Halved(from);
  cv::Mat half_to = Halved(to);
  cv::copyMakeBorder(half_to, half_to, 0, 0, kLeft, kLeft, cv::BORDER_CONSTANT);
  std::vector<std::optional<cv::Point>> displacements(places.size());
  const size_t tasks = (places.size() + kPlacesPerTask - 1) / kPlacesPerTask;
  kernels::ParallelFor(static_cast<int64_t>(tasks), [&](int64_t task) {
    const size_t begin = static_cast<size_t>(task) * kPlacesPerTask;
    for (size_t i = begin; i < std::min(places.size(), begin + kPlacesPerTask); ++i) {
      displacements[i] =
          DistinctDisplacement(half_from, half_to, static_cast<int>(places[i].x / 2) - kSide / 2,
                               static_cast<int>(places[i].y / 2) - kSide / 2);
    }
  });
  Ways ways;
  for (size_t i = 0; i < places.size(); ++i) {
    if (!displacements[i]) continue;
    ways.owners.push_back(i);
    ways.starts.push_back(places[i]);
    ways.ends.push_back(places[i] + 2.0f * cv::Point2f(*displacements[i]));
  }
  return ways;
}

// In both directions.
void Align(const FlowPicture& from, const FlowPicture& to, Ways& ways) {
  std::vector<uint8_t> kept(ways.owners.size(), 0);
  kernels::ParallelFor(static_cast<int64_t>(kept.size()), [&](int64_t k) {
    const cv::Point2f start = FlowPatchCorner(ways.starts[k]);
    const cv::Point2f coarse = FlowPatchCorner(ways.ends[k]);
    if (!from.HoldsPatch(start)) return;
    const FlowPatch patch(from, start);
    const auto [there, match] = patch.Align(to, coarse, kMostSteps);
    if (!to.HoldsPatch(there) || cv::norm(there - coarse) > kMostAligned) return;
    if (patch.Correlation(match) < kLeastCorrelation) return;
    const cv::Point2f back = FlowPatch(to, there).Align(from, start, kMostSteps).corner;
    if (cv::norm(back - start) > kMostReturn) return;
    ways.ends[k] = ways.starts[k] + (there - start);
    kept[k] = 1;
  });
  ways.Keep(kept);
}

void DropLone(int spacing, Ways& ways) {
  const auto cell = [&](cv::Point2f place) {
    return std::pair(static_cast<int>(place.x) / spacing, static_cast<int>(place.y) / spacing);
  };
  std::map<std::pair<int, int>, cv::Point2f> way_at;
  for (size_t k = 0; k < ways.owners.size(); ++k) way_at[cell(ways.starts[k])] = ways.Way(k);
  std::vector<uint8_t> kept(ways.owners.size());
  for (size_t k = 0; k < kept.size(); ++k) {
    const auto [column, row] = cell(ways.starts[k]);
    const double most = kAlikeFloor + kAlikeSlope * cv::norm(ways.Way(k));
    int alike = -1;  // does not count itself
    for (int x = column - kNeighbourhood; x <= column + kNeighbourhood; ++x) {
      for (int y = row - kNeighbourhood; y <= row + kNeighbourhood; ++y) {
        const auto other = way_at.find({x, y});
        alike += other != way_at.end() && cv::norm(other->second - ways.Way(k)) < most;
      }
    }
    kept[k] = alike >= kFewestAlike ? 1 : 0;
  }
  ways.Keep(kept);
}

}  // namespace

std::vector<std::optional<cv::Point2f>> SearchPatches(const FlowPicture& from,
                                                      const FlowPicture& to,
                                                      const std::vector<cv::Point2f>& places,
                                                      int spacing) {
  Ways ways = CoarseWays(from, to, places);
  Align(from, to, ways);
  DropLone(spacing, ways);
  std::vector<std::optional<cv::Point2f>> found(places.size());
  for (size_t k = 0; k < ways.owners.size(); ++k) found[ways.owners[k]] = ways.ends[k];
  return found;
}

}  // namespace egosieve::vision
