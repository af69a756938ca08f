#include "vision/objects/map_objects.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_format.h"

namespace egosieve::vision {

absl::Status ObjectThresholds::Validate() const {
  if (low >= 0.0 && low <= high && high <= 1.0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "--object_low=%g and --object_high=%g; both must lie in [0, 1], the first not above the "
      "second",
      low, high));
}

cv::Mat1i NumberObjects(const cv::Mat1b& above_low, const cv::Mat1b& above_high) {
  cv::Mat1i regions;
  const int count = cv::connectedComponents(above_low, regions, 8, CV_32S);
  std::vector<bool> is_object(count, false);
  for (int y = 0; y < regions.rows; ++y) {
    for (int x = 0; x < regions.cols; ++x) {
      if (above_high(y, x) != 0) is_object[regions(y, x)] = true;
    }
  }
  is_object[0] = false;
  std::vector<int> numbers(count, 0);
  int objects = 0;
  for (int& region : regions) {
    if (is_object[region] && numbers[region] == 0) numbers[region] = ++objects;
    region = numbers[region];
  }
  return regions;
}

std::vector<MapObject> FindObjects(const cv::Mat1f& probability,
                                   const ObjectThresholds& thresholds) {
  if (probability.empty()) return {};
  const cv::Mat1i numbers =
      NumberObjects(probability >= thresholds.low, probability >= thresholds.high);
  std::vector<MapObject> objects;
  for (int y = 0; y < numbers.rows; ++y) {
    for (int x = 0; x < numbers.cols; ++x) {
      const int number = numbers(y, x);
      if (number == 0) continue;
      if (number > static_cast<int>(objects.size())) objects.resize(number);
      MapObject& object = objects[number - 1];
      object.box |= cv::Rect(x, y, 1, 1);
      ++object.pixels;
      const double p = probability(y, x);
      object.peak = std::max(object.peak, p);
      object.mean += p;
      object.sure -= 2.0 * std::sqrt(p * (1.0 - p));
    }
  }
  for (MapObject& object : objects) {
    object.mean /= static_cast<double>(object.pixels);
    object.sure = 1.0 + object.sure / static_cast<double>(object.pixels);
  }
  return objects;
}

}  // namespace egosieve::vision
