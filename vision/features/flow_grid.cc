#include "vision/features/flow_grid.h"

#include <algorithm>
#include <cmath>
#include <opencv2/video/tracking.hpp>

#include "absl/strings/str_cat.h"

namespace egosieve::vision {
namespace {

constexpr int kMinimumSide = 16;

int Preset(FlowQuality quality) {
  switch (quality) {
    case FlowQuality::kUltrafast:
      return cv::DISOpticalFlow::PRESET_ULTRAFAST;
    case FlowQuality::kFast:
      return cv::DISOpticalFlow::PRESET_FAST;
    case FlowQuality::kMedium:
      break;
  }
  return cv::DISOpticalFlow::PRESET_MEDIUM;
}

}  // namespace

absl::Status FlowGridOptions::Validate() const {
  if (stride_pixels < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("stride_pixels is ", stride_pixels, "; it must be positive"));
  }
  if (!(error_floor > 0) || !std::isfinite(error_floor)) {
    return absl::InvalidArgumentError(
        absl::StrCat("error_floor is ", error_floor, "; it must be positive"));
  }
  if (!(error_slope >= 0) || !std::isfinite(error_slope)) {
    return absl::InvalidArgumentError(
        absl::StrCat("error_slope is ", error_slope, "; it must not be negative"));
  }
  return absl::OkStatus();
}

absl::StatusOr<FlowPair> ComputeFlow(const cv::Mat& first, const cv::Mat& second,
                                     FlowQuality quality) {
  if (first.size() != second.size() || first.type() != CV_8UC1 || second.type() != CV_8UC1) {
    return absl::InvalidArgumentError("flow needs two grey 8-bit images of one size");
  }
  if (first.cols < kMinimumSide || first.rows < kMinimumSide) {
    return absl::InvalidArgumentError(
        absl::StrCat("flow needs images of at least ", kMinimumSide, " pixels in each direction"));
  }
  FlowPair flow;
  try {
    const auto dis = cv::DISOpticalFlow::create(Preset(quality));
    dis->calc(first, second, flow.forward);
    dis->calc(second, first, flow.backward);
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("flow: ", error.err));
  }
  return flow;
}

cv::Point2f SampleField(const cv::Mat& field, cv::Point2f at) {
  const float x = std::clamp(at.x, 0.0F, static_cast<float>(field.cols - 1));
  const float y = std::clamp(at.y, 0.0F, static_cast<float>(field.rows - 1));
  const int x0 = std::min(static_cast<int>(x), std::max(field.cols - 2, 0));
  const int y0 = std::min(static_cast<int>(y), std::max(field.rows - 2, 0));
  const int x1 = std::min(x0 + 1, field.cols - 1), y1 = std::min(y0 + 1, field.rows - 1);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const auto at_pixel = [&](int row, int column) { return field.at<cv::Point2f>(row, column); };
  return (1 - fy) * ((1 - fx) * at_pixel(y0, x0) + fx * at_pixel(y0, x1)) +
         fy * ((1 - fx) * at_pixel(y1, x0) + fx * at_pixel(y1, x1));
}

std::vector<PointPair> TrackGrid(const FlowPair& flow, bool anchor_second,
                                 const FlowGridOptions& options) {
  const cv::Mat& there = anchor_second ? flow.backward : flow.forward;
  const cv::Mat& back = anchor_second ? flow.forward : flow.backward;
  std::vector<PointPair> pairs;
  for (int y = options.stride_pixels / 2; y < there.rows; y += options.stride_pixels) {
    for (int x = options.stride_pixels / 2; x < there.cols; x += options.stride_pixels) {
      const cv::Point2f f = there.at<cv::Point2f>(y, x);
      const cv::Point2f moved(x + f.x, y + f.y);
      const bool inside = moved.x >= 0 && moved.y >= 0 && moved.x <= there.cols - 1 &&
                          moved.y <= there.rows - 1;  // false for NaN
      if (!inside) continue;
      const cv::Point2f b = SampleField(back, moved);
      const double error = std::hypot(f.x + b.x, f.y + b.y);
      if (!(error < options.error_floor + options.error_slope * std::hypot(f.x, f.y))) continue;
      const PointPair pair{static_cast<double>(x), static_cast<double>(y), moved.x, moved.y};
      pairs.push_back(anchor_second ? PointPair{pair.x2, pair.y2, pair.x1, pair.y1} : pair);
    }
  }
  return pairs;
}

}  // namespace egosieve::vision
