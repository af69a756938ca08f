#include "vision/evidence/own_car.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "vision/evidence/epipolar_line.h"

namespace egosieve::vision {
namespace {

constexpr int kBlock = 8;                             // pixels of the half image
constexpr double kStillCost = 4.0, kStillGain = 9.0;  // of (O4), in sigma^2
constexpr double kStillShift = 0.15;                  // pixels of the half image
constexpr double kGradientOfSobel = 1.0 / 8.0;

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

// (O4): whether (O1) is out of the question.
bool IsMoving(const BlockSums& sums, double pixels, double variance) {
  if (!(sums.dd <= kStillCost * pixels * variance)) return true;
  const double determinant = sums.gg.determinant();
  const double trace = sums.gg.trace();
  // Along an edge only the motion across it is known.
  const Eigen::Matrix2d damped = sums.gg + (1e-6 * trace + 1e-9) * Eigen::Matrix2d::Identity();
  if (!(determinant > 1e-3 * trace * trace)) {
    const double across = trace > 0 ? sums.dg.norm() / trace : 0.0;
    return across > kStillShift && across * sums.dg.norm() > kStillGain * variance;
  }
  const Eigen::Vector2d w = -damped.inverse() * sums.dg;
  return w.norm() > kStillShift && -w.dot(sums.dg) > kStillGain * variance;
}

void LearnFrom(const cv::Mat& before, const cv::Mat& now, const WorldMotion& motion,
               const OwnCarOptions& options, OwnCarState& state) {
  cv::Mat difference, mean, gx, gy;
  cv::subtract(now, before, difference, cv::noArray(), CV_32F);
  cv::addWeighted(now, 0.5, before, 0.5, 0.0, mean, CV_32F);
  cv::Sobel(mean, gx, CV_32F, 1, 0, 3, kGradientOfSobel);
  cv::Sobel(mean, gy, CV_32F, 0, 1, 3, kGradientOfSobel);
  const int64_t count = state.sums.size();
  std::vector<BlockSums> sums(count);
  std::vector<double> levels(count);
  std::vector<double> pixels(count);
  const cv::Rect whole(0, 0, now.cols, now.rows);
  for (int64_t k = 0; k < count; ++k) {
    const int row = static_cast<int>(k) / state.blocks.width;
    const int column = static_cast<int>(k) % state.blocks.width;
    const cv::Rect block = cv::Rect(column * kBlock, row * kBlock, kBlock, kBlock) & whole;
    sums[k] = Sum(difference, gx, gy, block);
    pixels[k] = static_cast<double>(block.area());
    levels[k] = sums[k].dd / pixels[k];
  }
  std::vector<double> sorted = levels;
  std::nth_element(sorted.begin(), sorted.begin() + count / 4, sorted.end());
  const double variance = std::max(sorted[count / 4], options.noise_floor * options.noise_floor);
  for (int64_t k = 0; k < count; ++k) {
    const int row = static_cast<int>(k) / state.blocks.width;
    const int column = static_cast<int>(k) % state.blocks.width;
    // The half image's pixel i covers 2 i and 2 i + 1.
    const BlockMotion block =
        MotionAt(motion, 2.0 * kBlock * (column + 0.5) - 0.5, 2.0 * kBlock * (row + 0.5) - 0.5);
    double ratio = 0.0;
    if (block.valid) {
      ratio = (WorldCost(sums[k], block) - sums[k].dd) / (2.0 * pixels[k] * variance);
    }
    if (ratio > 0.0 && IsMoving(sums[k], pixels[k], variance)) ratio = -1.0;
    const double sum = options.memory * state.sums[k] + std::clamp(ratio, -1.0, 1.0);
    state.sums[k] = static_cast<float>(std::clamp(sum, -options.limit, options.limit));
    if (state.sums[k] > options.on) state.is_own[k] = 1;
    if (state.sums[k] < options.off) state.is_own[k] = 0;
  }
}

}  // namespace

absl::Status OwnCarOptions::Validate() const {
  const auto error = [](auto... parts) {
    return absl::InvalidArgumentError(absl::StrCat(parts...));
  };
  if (!(limit > 0) || !std::isfinite(limit))
    return error("limit is ", limit, "; it must be positive");
  if (!(on > 0 && on <= limit)) return error("on is ", on, "; it must lie in (0, ", limit, "]");
  if (!(off < on) || !std::isfinite(off))
    return error("off is ", off, "; it must be below on, ", on);
  if (!(memory > 0 && memory < 1)) return error("memory is ", memory, "; it must lie in (0, 1)");
  if (!(noise_floor > 0) || !std::isfinite(noise_floor)) {
    return error("noise_floor is ", noise_floor, "; it must be positive");
  }
  return absl::OkStatus();
}

void LearnOwnCar(const cv::Mat& grey, int64_t index, int gap, const WorldMotion* motion,
                 const OwnCarOptions& options, OwnCarState& state) {
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
    LearnFrom(earlier, half, *motion, options, state);
  }
  std::erase_if(state.images, [&](const auto& image) { return image.index <= index - gap; });
  OwnCarState::HalfImage kept;
  kept.index = index;
  kept.size = half.size();
  kept.pixels.assign(half.datastart, half.dataend);
  state.images.push_back(std::move(kept));
}

bool IsOwnCar(const OwnCarState& state, cv::Point2f place) {
  const float column = place.x / (2 * kBlock), row = place.y / (2 * kBlock);
  const bool inside = column >= 0 && row >= 0 && column < static_cast<float>(state.blocks.width) &&
                      row < static_cast<float>(state.blocks.height);
  if (!inside) return false;
  return state.is_own[static_cast<int>(row) * state.blocks.width + static_cast<int>(column)] != 0;
}

std::vector<cv::Rect> OwnCarAreas(const OwnCarState& state, cv::Size image) {
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
