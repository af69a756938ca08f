#include "vision/labelling/reduced_labels.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace egosieve::vision {
namespace {

// (RL1), of x or y.
double Enlarged(double place, double scale) { return (place + 0.5) * scale - 0.5; }

void EnlargePlaces(double x_scale, double y_scale, std::vector<double>& places) {
  for (size_t i = 0; i + 1 < places.size(); i += 2) {
    places[i] = Enlarged(places[i], x_scale);
    places[i + 1] = Enlarged(places[i + 1], y_scale);
  }
}

}  // namespace

cv::Size ReducedSize(cv::Size full, int longest_side_pixels) {
  const int longer = std::max(full.width, full.height);
  if (longest_side_pixels == 0 || longer <= longest_side_pixels) return full;
  const double scale = static_cast<double>(longest_side_pixels) / longer;
  return {std::max(1, cvRound(full.width * scale)), std::max(1, cvRound(full.height * scale))};
}

cv::Mat ReducePicture(const cv::Mat& picture, int longest_side_pixels) {
  const cv::Size size = ReducedSize(picture.size(), longest_side_pixels);
  if (size == picture.size()) return picture;
  cv::Mat reduced;
  cv::resize(picture, reduced, size, 0.0, 0.0, cv::INTER_AREA);
  return reduced;
}

cv::Mat1b ReduceMask(const cv::Mat1b& mask, int longest_side_pixels) {
  const cv::Size size = ReducedSize(mask.size(), longest_side_pixels);
  if (mask.empty() || size == mask.size()) return mask;
  cv::Mat1b reduced;
  cv::resize(mask, reduced, size, 0.0, 0.0, cv::INTER_NEAREST);
  return reduced;
}

PointPair EnlargePair(const PointPair& pair, cv::Size reduced, cv::Size full) {
  if (reduced == full) return pair;
  const double x_scale = static_cast<double>(full.width) / reduced.width;
  const double y_scale = static_cast<double>(full.height) / reduced.height;
  return {Enlarged(pair.x1, x_scale), Enlarged(pair.y1, y_scale), Enlarged(pair.x2, x_scale),
          Enlarged(pair.y2, y_scale)};
}

void EnlargeLabels(cv::Size reduced, cv::Size full, LabelledFrame& labels) {
  if (reduced == full) return;
  const double x_scale = static_cast<double>(full.width) / reduced.width;
  const double y_scale = static_cast<double>(full.height) / reduced.height;
  const double scale = std::sqrt(x_scale * y_scale);
  EnlargePlaces(x_scale, y_scale, labels.positions);
  EnlargePlaces(x_scale, y_scale, labels.other_positions);
  labels.parallax_pixels *= scale;
  labels.noise_pixels *= scale;
}

}  // namespace egosieve::vision
