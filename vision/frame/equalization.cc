#include "vision/frame/equalization.h"

#include <opencv2/imgproc.hpp>

namespace egosieve::vision {
namespace {

constexpr double kClipLimit = 2.0;  // of a tile's histogram, in units of its mean height
constexpr int kTiles = 8;           // along each side of the image

cv::Mat EqualizeChannel(const cv::Mat& luminance, Equalization method) {
  cv::Mat result;
  if (method == Equalization::kGlobal) {
    cv::equalizeHist(luminance, result);
  } else {
    cv::createCLAHE(kClipLimit, cv::Size(kTiles, kTiles))->apply(luminance, result);
  }
  return result;
}

}  // namespace

cv::Mat EqualizeLuminance(const cv::Mat& image, Equalization method) {
  if (method == Equalization::kNone || image.empty()) return image;
  if (image.channels() == 1) return EqualizeChannel(image, method);
  cv::Mat luminance_chrominance, result;
  cv::cvtColor(image, luminance_chrominance, cv::COLOR_BGR2YCrCb);
  cv::extractChannel(luminance_chrominance, result, 0);
  cv::insertChannel(EqualizeChannel(result, method), luminance_chrominance, 0);
  cv::cvtColor(luminance_chrominance, result, cv::COLOR_YCrCb2BGR);
  return result;
}

cv::Mat EqualizedGrey(const cv::Mat& image, Equalization method) {
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return EqualizeLuminance(grey, method);
}

}  // namespace egosieve::vision
