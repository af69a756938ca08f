#include "tools/evaluation/objects.h"

#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"

namespace egosieve::tools {
namespace {

// The id of the object nearest to each pixel; 0 if the image has no object.
cv::Mat1i NearestObject(const cv::Mat1i& ids) {
  cv::Mat1i nearest = cv::Mat1i::zeros(ids.size());
  const cv::Mat1b background = ids == 0;
  if (cv::countNonZero(background) == static_cast<int>(ids.total())) return nearest;
  cv::Mat1f distance;
  cv::Mat1i labels;
  cv::distanceTransform(background, distance, labels, cv::DIST_L2, cv::DIST_MASK_5,
                        cv::DIST_LABEL_PIXEL);
  std::map<int, int> id_of_label;
  for (int y = 0; y < ids.rows; ++y) {
    for (int x = 0; x < ids.cols; ++x) {
      if (ids(y, x) != 0) id_of_label[labels(y, x)] = ids(y, x);
    }
  }
  for (int y = 0; y < ids.rows; ++y) {
    for (int x = 0; x < ids.cols; ++x) nearest(y, x) = id_of_label[labels(y, x)];
  }
  return nearest;
}

struct Prediction {
  int area = 0;
  int on_objects = 0;  // or on void pixels
};

struct Overlap {
  int area = 0;
  int hit = 0;      // |P and o|
  int charged = 0;  // predicted pixels outside the object, assigned to it
};

}  // namespace

absl::Status ObjectOptions::Validate() const {
  const auto share = [](const char* field, double value) {
    if (value > 0.0 && value <= 1.0) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrFormat("%s = %g; it must be above 0 and at most 1", field, value));
  };
  EGOSIEVE_RETURN_IF_ERROR(thresholds.Validate());
  EGOSIEVE_RETURN_IF_ERROR(share("iou_threshold", iou_threshold));
  EGOSIEVE_RETURN_IF_ERROR(share("min_overlap", min_overlap));
  if (min_area < 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("min_area = %d; it must be at least 1", min_area));
  }
  return absl::OkStatus();
}

cv::Mat1i ComponentsOf(const cv::Mat1b& mask) {
  cv::Mat1i labels;
  cv::connectedComponents(mask, labels, 8, CV_32S);
  return labels;
}

absl::StatusOr<ObjectScores> ScoreObjects(const cv::Mat1i& predicted, const cv::Mat1i& ids,
                                          const cv::Mat1b& void_pixels,
                                          const ObjectOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (predicted.size() != ids.size() ||
      (!void_pixels.empty() && void_pixels.size() != ids.size())) {
    return absl::InvalidArgumentError(
        absl::StrFormat("a map of %d x %d and objects of %d x %d pixels cannot be compared",
                        predicted.cols, predicted.rows, ids.cols, ids.rows));
  }
  const auto is_void = [&](int y, int x) { return !void_pixels.empty() && void_pixels(y, x) != 0; };
  const cv::Mat1i nearest = NearestObject(ids);
  std::map<int, Prediction> found;
  std::map<int, Overlap> overlaps;
  std::set<std::pair<int, int>> touching;  // predicted, object
  for (int y = 0; y < ids.rows; ++y) {
    for (int x = 0; x < ids.cols; ++x) {
      const int number = predicted(y, x), id = ids(y, x);
      if (id != 0) ++overlaps[id].area;
      if (number == 0) continue;
      ++found[number].area;
      found[number].on_objects += id != 0 || is_void(y, x);
      if (id == 0) continue;
      ++overlaps[id].hit;
      touching.emplace(number, id);
    }
  }
  for (int y = 0; y < ids.rows; ++y) {
    for (int x = 0; x < ids.cols; ++x) {
      const int number = predicted(y, x);
      if (number == 0 || ids(y, x) != 0 || is_void(y, x)) continue;
      if (touching.count({number, nearest(y, x)}) > 0) ++overlaps[nearest(y, x)].charged;
    }
  }
  ObjectScores scores;
  for (const auto& [id, overlap] : overlaps) {
    if (overlap.area < options.min_area) continue;
    const double iou = static_cast<double>(overlap.hit) / (overlap.area + overlap.charged);  // (1)
    scores.objects.push_back({id, overlap.area, iou, iou >= options.iou_threshold});
  }
  for (const auto& [number, prediction] : found) {
    scores.false_objects += prediction.area >= options.min_area &&
                            prediction.on_objects < options.min_overlap * prediction.area;
  }
  return scores;
}

}  // namespace egosieve::tools
