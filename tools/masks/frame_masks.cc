#include "tools/masks/frame_masks.h"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/masks/cast_shadows.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

constexpr int kMostPixels = 1000;

absl::Status CheckPixels(const char* flag, int pixels) {
  if (pixels >= 0 && pixels <= kMostPixels) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(flag, "=", pixels, "; it must lie in [0, ", kMostPixels, "]"));
}

absl::StatusOr<cv::Mat> ReadOfType(const std::string& path, int type, cv::Size size) {
  absl::StatusOr<cv::Mat> image = ReadImage(path, cv::IMREAD_UNCHANGED);
  if (image.ok() && image->type() == type && image->size() == size) return image;
  return absl::DataLossError(
      absl::StrCat(path, " is missing or damaged; run egosieve refine again"));
}

}  // namespace

absl::Status FrameMaskOptions::Validate() const {
  if (threshold && !(*threshold >= 0.0 && *threshold <= 1.0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--threshold=", *threshold, "; a probability lies in [0, 1]"));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckPixels("--dilate", dilate_pixels));
  return CheckPixels("--shadow_margin", shadow_margin_pixels);
}

std::string MaskSource(const RunFolder& folder, int64_t index, const FrameMaskOptions& options) {
  if (options.threshold) return folder.FrameFile("full", index, ".prob.png");
  return folder.FrameFile(options.numbers ? "ids" : "masks", index, ".png");
}

absl::StatusOr<FrameMask> ReadFrameMask(const RunFolder& folder, const FrameLine& line,
                                        const FrameMaskOptions& options, const cv::Mat3b& picture) {
  const cv::Size size(line.width_pixels, line.height_pixels);
  const std::string path = MaskSource(folder, line.index, options);
  FrameMask mask;
  if (options.threshold) {
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat map, ReadOfType(path, CV_16UC1, size));
    mask.masked = map >= static_cast<int>(std::ceil(*options.threshold * 65535.0));
  } else if (options.numbers) {
    EGOSIEVE_ASSIGN_OR_RETURN(mask.numbers, ReadOfType(path, CV_16UC1, size));
    mask.masked = mask.numbers != 0;
  } else {
    EGOSIEVE_ASSIGN_OR_RETURN(mask.masked, ReadOfType(path, CV_8UC1, size));
  }
  if (options.shadow_margin_pixels > 0 && !picture.empty()) {
    cv::Mat shown = picture;
    if (shown.size() != size) cv::resize(picture, shown, size, 0, 0, cv::INTER_AREA);
    mask.masked |= FindCastShadows(shown, mask.masked, options.shadow_margin_pixels);
  }
  Dilate(options.dilate_pixels, mask.masked, mask.numbers);
  const cv::Mat1b own = options.ignored.In(line);
  if (options.own_vehicle) {
    mask.masked.setTo(255, own);
  } else if (options.threshold) {  // refine's own masks exclude it already
    mask.masked.setTo(0, own);
  }
  return mask;
}

void Dilate(int pixels, cv::Mat1b& masked, cv::Mat1w& numbers) {
  if (pixels == 0 || cv::countNonZero(masked) == 0) return;
  cv::Mat1f distance;
  cv::distanceTransform(masked == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  if (numbers.empty()) {
    masked = distance <= static_cast<double>(pixels);
    return;
  }
  cv::Mat1f nearest_distance;
  cv::Mat1i nearest;
  cv::distanceTransform(numbers == 0, nearest_distance, nearest, cv::DIST_L2, cv::DIST_MASK_5,
                        cv::DIST_LABEL_PIXEL);
  std::vector<uint16_t> number_of(numbers.total() + 1, 0);
  for (int y = 0; y < numbers.rows; ++y) {
    for (int x = 0; x < numbers.cols; ++x) {
      if (numbers(y, x) != 0) number_of[nearest(y, x)] = numbers(y, x);
    }
  }
  masked = distance <= static_cast<double>(pixels);
  for (int y = 0; y < numbers.rows; ++y) {
    for (int x = 0; x < numbers.cols; ++x) {
      if (masked(y, x) != 0) numbers(y, x) = number_of[nearest(y, x)];
    }
  }
}

}  // namespace egosieve::tools
