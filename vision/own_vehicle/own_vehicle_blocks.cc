#include "vision/own_vehicle/own_vehicle_blocks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "vision/evidence/epipolar_line.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr int kBlock = 8;                             // pixels of the half image
constexpr double kStillCost = 4.0, kStillGain = 9.0;  // of (O4), in sigma^2
constexpr double kStillShift = 0.15;                  // pixels of the half image
constexpr double kGradientOfSobel = 1.0 / 8.0;
constexpr double kStillPixels = 0.5, kRoadPixels = 3.0;  // between t - g and t
constexpr double kStillShare = 0.1;                      // of the road's motion: cameras shake
constexpr int kFewestPlaces = 2;
constexpr double kMostPlaces = 0.7;  // least share of a block's places that decides
constexpr double kGainByRoad = 3.0;
constexpr int kRowsPerGap = 10;  // one block of gap is allowed per so many rows of blocks

cv::Mat HalfOf(const cv::Mat& grey) {
  cv::Mat half;
  cv::resize(grey, half, cv::Size((grey.cols + 1) / 2, (grey.rows + 1) / 2), 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(half, half, cv::Size(5, 5), 1.0);
  return half;
}

// v and d at a place, pixels of the half image.
struct BlockMotion {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  // zero: no line
  bool valid = false;
};

BlockMotion MotionAt(const WorldMotion& motion, double x, double y) {
  BlockMotion block;
  const Eigen::Vector2d place(x, y);
  if (motion.has_line) {
    const EpipolarLine line =
        LineOf(motion.camera, motion.pose.rotation, motion.pose.translation, x, y);
    if (!line.valid) return block;
    block.shift = 0.5 * (line.infinity - place);
    block.direction = line.direction;
  } else {
    const Eigen::Vector3d moved = motion.homography * Eigen::Vector3d(x, y, 1.0);
    if (!(std::abs(moved(2)) > 1e-12)) return block;
    block.shift = 0.5 * (moved.head<2>() / moved(2) - place);
  }
  block.valid = block.shift.allFinite();
  return block;
}

// Sums over a block: D^2, D G, G G^T.
struct BlockSums {
  double dd = 0.0;
  Eigen::Vector2d dg = Eigen::Vector2d::Zero();
  Eigen::Matrix2d gg = Eigen::Matrix2d::Zero();
};

BlockSums Sum(const cv::Mat& difference, const cv::Mat& gx, const cv::Mat& gy, cv::Rect block) {
  BlockSums sums;
  for (int y = block.y; y < block.y + block.height; ++y) {
    const float *d = difference.ptr<float>(y), *u = gx.ptr<float>(y), *v = gy.ptr<float>(y);
    for (int x = block.x; x < block.x + block.width; ++x) {
      sums.dd += d[x] * d[x];
      sums.dg += d[x] * Eigen::Vector2d(u[x], v[x]);
      sums.gg(0, 0) += u[x] * u[x];
      sums.gg(0, 1) += u[x] * v[x];
      sums.gg(1, 1) += v[x] * v[x];
    }
  }
  sums.gg(1, 0) = sums.gg(0, 1);
  return sums;
}

// (O2).
double WorldCost(const BlockSums& sums, const BlockMotion& motion) {
  const Eigen::Vector2d gv = sums.gg * motion.shift;
  const double at_infinity = sums.dd + 2.0 * sums.dg.dot(motion.shift) + motion.shift.dot(gv);
  const double curvature = motion.direction.dot(sums.gg * motion.direction);
  const double slope = motion.direction.dot(sums.dg + gv);
  if (!(curvature > 0.0) || !(slope < 0.0)) return at_infinity;
  return at_infinity - slope * slope / curvature;
}

// Whether the block is not still by (O4).
bool IsMoving(const BlockSums& sums, double pixels, double variance) {
  if (!(sums.dd <= kStillCost * pixels * variance)) return true;
  const double determinant = sums.gg.determinant();
  const double trace = sums.gg.trace();
  // On an edge, only the motion across it is observable.
  const Eigen::Matrix2d damped = sums.gg + (1e-6 * trace + 1e-9) * Eigen::Matrix2d::Identity();
  if (!(determinant > 1e-3 * trace * trace)) {
    const double across = trace > 0 ? sums.dg.norm() / trace : 0.0;
    return across > kStillShift && across * sums.dg.norm() > kStillGain * variance;
  }
  const Eigen::Vector2d w = -damped.inverse() * sums.dg;
  return w.norm() > kStillShift && -w.dot(sums.dg) > kStillGain * variance;
}

// The blocks of a pair of images: sums, numbers of pixels, and the variance of the image noise.
struct Blocks {
  std::vector<BlockSums> sums;
  std::vector<double> pixels;
  double variance = 0.0;
};

Blocks BlocksOf(const cv::Mat& before, const cv::Mat& now, cv::Size blocks, double noise_floor) {
  cv::Mat difference, mean, gx, gy;
  cv::subtract(now, before, difference, cv::noArray(), CV_32F);
  cv::addWeighted(now, 0.5, before, 0.5, 0.0, mean, CV_32F);
  cv::Sobel(mean, gx, CV_32F, 1, 0, 3, kGradientOfSobel);
  cv::Sobel(mean, gy, CV_32F, 0, 1, 3, kGradientOfSobel);
  Blocks result;
  std::vector<double> levels;
  const cv::Rect whole(0, 0, now.cols, now.rows);
  for (int row = 0; row < blocks.height; ++row) {
    for (int column = 0; column < blocks.width; ++column) {
      const cv::Rect block = cv::Rect(column * kBlock, row * kBlock, kBlock, kBlock) & whole;
      result.sums.push_back(Sum(difference, gx, gy, block));
      result.pixels.push_back(static_cast<double>(block.area()));
      levels.push_back(result.sums.back().dd / result.pixels.back());
    }
  }
  result.variance = std::max(OfRankInPlace(levels, levels.size() / 4), noise_floor * noise_floor);
  return result;
}

// Greatest number of blocks in a gap that is bridged.
int MostGap(cv::Size blocks) { return std::max(1, blocks.height / kRowsPerGap); }

// Flags the blocks of short gaps between flagged blocks, unless they were seen to move. The line of
// `count` blocks starts at `first`, in steps of `step`.
void FillGaps(int first, int step, int count, double off, bool edge_is_own,
              OwnVehicleBlocks& state) {
  const int most_gap = MostGap(state.blocks);
  int last = edge_is_own ? -1 : -most_gap - 2;
  for (int i = 0; i < count; ++i) {
    if (state.is_own[first + i * step] == 0) continue;
    for (int gap = last + 1; gap < i && i - last <= most_gap + 1; ++gap) {
      const int k = first + gap * step;
      if (state.sums[k] > -off) state.is_own[k] = 1;
    }
    last = i;
  }
}

// Fills gaps in columns and rows, because parts of a bonnet are blank.
void FillOwnVehicle(double off, OwnVehicleBlocks& state) {
  const int columns = state.blocks.width, rows = state.blocks.height;
  for (int column = 0; column < columns; ++column) {
    FillGaps((rows - 1) * columns + column, -columns, rows, off, true, state);
  }
  for (int row = 0; row < rows; ++row) FillGaps(row * columns, 1, columns, off, false, state);
}

// Image motion of the road at the place of a pair, pixels; 0 above the horizon.
double RoadMotionAt(const WorldMotion& motion, const PointPair& pair) {
  const RelativePose& pose = motion.pose;
  const Eigen::Vector3d ray = pose.rotation * motion.camera.Ray(pair.x1, pair.y1);
  const double ahead = 1.0 - motion.road.m.dot(pose.translation);
  const double inverse_depth = motion.road.m.dot(ray) / ahead;  // m.(R X + t) = 1
  const Eigen::Vector3d point = ray + inverse_depth * pose.translation;
  if (!(ahead > 0.0) || !(inverse_depth > 0.0) || !(point(2) > 0.1)) return 0.0;
  return (motion.camera.Project(point) - Eigen::Vector2d(pair.x1, pair.y1)).norm();
}

enum class ByRoad { kSilent, kStill, kMoving };

// Compares the motion of each block's places with the road's.
std::vector<ByRoad> JudgeByRoad(const WorldMotion& motion, cv::Size blocks) {
  std::vector<ByRoad> judged(blocks.area(), ByRoad::kSilent);
  if (!motion.has_line || !motion.road.found) return judged;
  std::vector<int> still(judged.size(), 0), all(judged.size(), 0);
  for (const PointPair& pair : motion.pairs) {
    const int column = static_cast<int>(pair.x2) / (2 * kBlock);
    const int row = static_cast<int>(pair.y2) / (2 * kBlock);
    if (column < 0 || row < 0 || column >= blocks.width || row >= blocks.height) continue;
    const double road_motion = RoadMotionAt(motion, pair);
    if (road_motion < kRoadPixels) continue;
    const int k = row * blocks.width + column;
    ++all[k];
    still[k] += std::hypot(pair.x2 - pair.x1, pair.y2 - pair.y1) <
                std::max(kStillPixels, kStillShare * road_motion);
  }
  for (size_t k = 0; k < judged.size(); ++k) {
    if (all[k] < kFewestPlaces) continue;
    if (still[k] >= kMostPlaces * all[k]) judged[k] = ByRoad::kStill;
    if (still[k] <= (1.0 - kMostPlaces) * all[k]) judged[k] = ByRoad::kMoving;
  }
  return judged;
}

// l of (O4), without the evidence from the road.
double GainOf(const BlockSums& sums, double pixels, double variance, const BlockMotion& block) {
  if (!block.valid) return 0.0;
  const double gain = (WorldCost(sums, block) - sums.dd) / (2.0 * pixels * variance);
  return gain > 0.0 && IsMoving(sums, pixels, variance) ? -1.0 : std::clamp(gain, -1.0, 1.0);
}

void LearnFrom(const Blocks& blocks, const WorldMotion& motion,
               const OwnVehicleBlocksOptions& options, OwnVehicleBlocks& state) {
  const std::vector<ByRoad> by_road = JudgeByRoad(motion, state.blocks);
  const int most_gap = MostGap(state.blocks);
  for (int column = 0; column < state.blocks.width; ++column) {
    int gap = 0;  // blocks since the last one with ByRoad::kStill, or since the lower edge
    for (int row = state.blocks.height - 1; row >= 0; --row) {
      const int k = row * state.blocks.width + column;
      gap += by_road[k] == ByRoad::kMoving ? most_gap + 1 : 1;
      const bool is_joined = by_road[k] == ByRoad::kStill && gap <= most_gap + 1;
      double gain = kGainByRoad;
      if (is_joined) {
        gap = 0;
      } else {
        // Pixel i of the half image covers the pixels 2 i and 2 i + 1.
        gain = GainOf(blocks.sums[k], blocks.pixels[k], blocks.variance,
                      MotionAt(motion, 2.0 * kBlock * (column + 0.5) - 0.5,
                               2.0 * kBlock * (row + 0.5) - 0.5));
      }
      const double sum = options.memory * state.sums[k] + gain;
      state.sums[k] = static_cast<float>(std::clamp(sum, -options.limit, options.limit));
      if (state.sums[k] > (is_joined ? options.off : options.on)) state.is_own[k] = 1;
      if (state.sums[k] < options.off) state.is_own[k] = 0;
    }
  }
  FillOwnVehicle(options.off, state);
}

}  // namespace

absl::Status OwnVehicleBlocksOptions::Validate() const {
  return kernels::CheckOptions({
      {"limit", limit, kernels::IsPositive(limit), "be positive"},
      {"on", on, on > 0 && on <= limit, absl::StrCat("lie in (0, ", limit, "]")},
      {"off", off, off < on && std::isfinite(off), absl::StrCat("be below on, ", on)},
      {"memory", memory, memory > 0 && memory < 1, "lie in (0, 1)"},
      {"noise_floor", noise_floor, kernels::IsPositive(noise_floor), "be positive"},
  });
}

void LearnOwnVehicleBlocks(const cv::Mat& grey, int64_t index, int gap, const WorldMotion* motion,
                           const OwnVehicleBlocksOptions& options, OwnVehicleBlocks& state) {
  const cv::Mat half = HalfOf(grey);
  const cv::Size blocks((half.cols + kBlock - 1) / kBlock, (half.rows + kBlock - 1) / kBlock);
  if (blocks != state.blocks || (!state.images.empty() && state.images[0].size != half.size())) {
    state = {};
    state.blocks = blocks;
    state.sums.assign(blocks.area(), 0.0F);
    state.is_own.assign(blocks.area(), 0);
  }
  const auto before = std::find_if(state.images.begin(), state.images.end(),
                                   [&](const auto& image) { return image.index == index - gap; });
  if (motion != nullptr && before != state.images.end()) {
    const cv::Mat earlier(before->size, CV_8UC1, before->pixels.data());
    LearnFrom(BlocksOf(earlier, half, state.blocks, options.noise_floor), *motion, options, state);
  }
  std::erase_if(state.images, [&](const auto& image) { return image.index <= index - gap; });
  OwnVehicleBlocks::HalfImage kept;
  kept.index = index;
  kept.size = half.size();
  kept.pixels.assign(half.datastart, half.dataend);
  state.images.push_back(std::move(kept));
}

bool IsOwnVehicle(const OwnVehicleBlocks& state, cv::Point2f place) {
  const float column = place.x / (2 * kBlock), row = place.y / (2 * kBlock);
  const bool inside = column >= 0 && row >= 0 && column < static_cast<float>(state.blocks.width) &&
                      row < static_cast<float>(state.blocks.height);
  if (!inside) return false;
  return state.is_own[static_cast<int>(row) * state.blocks.width + static_cast<int>(column)] != 0;
}

std::vector<cv::Rect> OwnVehicleAreas(const OwnVehicleBlocks& state, cv::Size image) {
  constexpr int kPixels = 2 * kBlock;
  const cv::Rect whole(cv::Point(), image);
  std::vector<cv::Rect> areas;
  for (int row = 0; row < state.blocks.height; ++row) {
    const uint8_t* flags = state.is_own.data() + static_cast<int64_t>(row) * state.blocks.width;
    for (int column = 0; column < state.blocks.width; ++column) {
      if (flags[column] == 0) continue;
      const int from = column;
      while (column < state.blocks.width && flags[column] != 0) ++column;
      areas.push_back(whole &
                      cv::Rect(from * kPixels, row * kPixels, (column - from) * kPixels, kPixels));
    }
  }
  return areas;
}

}  // namespace egosieve::vision
