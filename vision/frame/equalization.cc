#include "vision/frame/equalization.h"

#include <opencv2/imgproc.hpp>

#include "kernels/base/argument_checks.h"

namespace egosieve::vision {
namespace {

cv::Mat EqualizeChannel(const cv::Mat& luminance, const EqualizationOptions& options) {
  cv::Mat result;
  if (options.method == Equalization::kGlobal) {
    cv::equalizeHist(luminance, result);
  } else {
    cv::createCLAHE(options.clahe_clip_limit, cv::Size(options.clahe_tiles, options.clahe_tiles))
        ->apply(luminance, result);
  }
  return result;
}

}  // namespace

absl::Status EqualizationOptions::Validate() const {
  return kernels::CheckOptions({
      {"clahe_clip_limit", clahe_clip_limit, clahe_clip_limit > 0, "be positive"},
      {"clahe_tiles", clahe_tiles, clahe_tiles >= 1 && clahe_tiles <= 64, "be from 1 to 64"},
  });
}

cv::Mat EqualizeLuminance(const cv::Mat& image, const EqualizationOptions& options) {
  if (options.method == Equalization::kNone || image.empty()) return image;
  if (image.channels() == 1) return EqualizeChannel(image, options);
  cv::Mat luminance_chrominance, result;
  cv::cvtColor(image, luminance_chrominance, cv::COLOR_BGR2YCrCb);
  cv::extractChannel(luminance_chrominance, result, 0);
  cv::insertChannel(EqualizeChannel(result, options), luminance_chrominance, 0);
  cv::cvtColor(luminance_chrominance, result, cv::COLOR_YCrCb2BGR);
  return result;
}

cv::Mat EqualizedGrey(const cv::Mat& image, const EqualizationOptions& options) {
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return EqualizeLuminance(grey, options);
}

}  // namespace egosieve::vision
