#include "vision/geometry/lens_correction.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

constexpr double kMostTangent = 3.73;  // of 75 degrees
constexpr double kMostReturn = 0.5;    // pixels
constexpr float kOutside = -1e4F;      // pixels

cv::Vec2f ToFloats(cv::Point2d place) {
  return {static_cast<float>(place.x), static_cast<float>(place.y)};
}

}  // namespace

absl::StatusOr<LensCorrection> LensCorrection::Create(const Lens& lens, cv::Size size) {
  if (size.width < 2 || size.height < 2) {
    return absl::InvalidArgumentError("the picture has a single row or column of pixels");
  }
  LensCorrection correction(lens, size);
  EGOSIEVE_RETURN_IF_ERROR(correction.ChooseFocal());
  correction.MakeMap();
  return correction;
}

std::vector<cv::Point2d> LensCorrection::RaysThrough(const std::vector<cv::Point2d>& pixels) const {
  const cv::Matx33d matrix(lens_.fx, 0.0, lens_.cx - 0.5, 0.0, lens_.fy, lens_.cy - 0.5, 0.0, 0.0,
                           1.0);
  const cv::Mat1d distortion(1, lens_.is_fisheye ? 4 : 8,
                             const_cast<double*>(&lens_.distortion[0]));
  std::vector<cv::Point2d> rays;
  if (lens_.is_fisheye) {
    cv::fisheye::undistortPoints(pixels, rays, matrix, distortion);
  } else {
    const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-9);
    cv::undistortPoints(pixels, rays, matrix, distortion, cv::noArray(), cv::noArray(), criteria);
  }
  return rays;
}

// (LC1)
absl::Status LensCorrection::ChooseFocal() {
  const cv::Point2d middle = Middle(), last = 2.0 * middle;
  const std::vector<cv::Point2d> sides = {
      {0.0, middle.y}, {last.x, middle.y}, {middle.x, 0.0}, {middle.x, last.y}};
  const std::vector<cv::Point2d> rays = RaysThrough(sides);
  focal_ = last.x + last.y;
  for (size_t k = 0; k < sides.size(); ++k) {
    const auto [x, y] = lens_.Project(rays[k].x, rays[k].y);
    const bool returns = cv::norm(cv::Point2d(x - 0.5, y - 0.5) - sides[k]) <= kMostReturn;
    const double tangent = (k % 2 == 0 ? -1.0 : 1.0) * (k < 2 ? rays[k].x : rays[k].y);
    if (!(returns && tangent > 0.0 && tangent <= kMostTangent)) {
      return absl::InvalidArgumentError(
          "the middle of a side of the picture is more than 75 degrees from the lens's axis, or "
          "beyond where its distortion folds the picture over; no pinhole camera shows this");
    }
    focal_ = std::min(focal_, (k < 2 ? middle.x : middle.y) / tangent);
  }
  return absl::OkStatus();
}

void LensCorrection::MakeMap() {
  for (int y = 0; y < there_.rows; ++y) {
    for (int x = 0; x < there_.cols; ++x) {
      there_(y, x) = ToFloats(Distort(cv::Point2d(x, y)));
    }
  }
  // Far from the axis a distortion may turn back, and show the picture once more, mirrored.
  const cv::Mat2f whole = there_.clone();
  for (int y = 0; y < there_.rows; ++y) {
    for (int x = 0; x < there_.cols; ++x) {
      const int left = std::max(x - 1, 0), upper = std::max(y - 1, 0);
      const cv::Vec2f across = whole(y, left + 1) - whole(y, left);
      const cv::Vec2f down = whole(upper + 1, x) - whole(upper, x);
      if (!(across[0] * down[1] - across[1] * down[0] > 0.0F)) there_(y, x) = {kOutside, kOutside};
    }
  }
}

bool LensCorrection::IsIdentity() const {
  for (int y = 0; y < there_.rows; ++y) {
    for (int x = 0; x < there_.cols; ++x) {
      if (!(cv::norm(there_(y, x) - cv::Vec2f(static_cast<float>(x), static_cast<float>(y))) <=
            0.5)) {
        return false;
      }
    }
  }
  return true;
}

cv::Mat LensCorrection::Correct(const cv::Mat& picture) const {
  cv::Mat corrected;
  cv::remap(picture, corrected, there_, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return corrected;
}

cv::Mat1b LensCorrection::CorrectMask(const cv::Mat1b& mask) const {
  const cv::Mat1b whole = mask.empty() ? cv::Mat1b(size(), uint8_t{0}) : mask;
  cv::Mat1b corrected;
  cv::remap(whole, corrected, there_, cv::noArray(), cv::INTER_NEAREST, cv::BORDER_CONSTANT, 255);
  return corrected;
}

cv::Mat1b LensCorrection::DistortMask(const cv::Mat1b& mask) const {
  if (mask.empty()) return mask;
  cv::Mat2f back(size());
  kernels::ParallelFor(back.rows, [&](int64_t row) {
    std::vector<cv::Point2d> pixels;
    for (int x = 0; x < back.cols; ++x) pixels.emplace_back(x, row);
    const std::vector<cv::Point2d> rays = RaysThrough(pixels);
    std::transform(rays.begin(), rays.end(), back.begin() + row * back.cols,
                   [&](const cv::Point2d& ray) { return ToFloats(focal_ * ray + Middle()); });
  });
  cv::Mat1b distorted;
  cv::remap(mask, distorted, back, cv::noArray(), cv::INTER_NEAREST, cv::BORDER_REPLICATE);
  return distorted;
}

cv::Point2d LensCorrection::Distort(cv::Point2d place) const {
  const cv::Point2d ray = (place - Middle()) / focal_;
  const auto [x, y] = lens_.Project(ray.x, ray.y);
  return {x - 0.5, y - 0.5};
}

}  // namespace egosieve::vision
