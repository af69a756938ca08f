// Which objects were found, and which predicted objects are false.
//
// The truth gives every pixel an object id (0: none), and so does the prediction (map_objects.h). A
// predicted object may cover several neighbouring objects of the truth. Therefore each of its
// pixels is assigned to the nearest of them:
//
//   IoU(o) = |P and o| / |o or { p in predicted objects that touch o : nearest(p) = o }|      (1)
//   found(o)      IoU(o) >= iou_threshold
//   false object  a predicted object of at least min_area pixels; the share of its pixels on
//                 objects (or on void pixels) is below `min_overlap`
//
// Objects below min_area pixels (of the scored map: grid or full) do not count as missed or false;
// their pixels remain in (1).
#ifndef EGOSIEVE_TOOLS_EVALUATION_OBJECTS_H_
#define EGOSIEVE_TOOLS_EVALUATION_OBJECTS_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/objects/map_objects.h"

namespace egosieve::tools {

struct ObjectOptions {
  vision::ObjectThresholds thresholds;  // of the prediction
  double iou_threshold = 0.5;
  int min_area = 4;          // pixels of the scored map
  double min_overlap = 0.1;  // least overlap of a predicted object that is not false

  absl::Status Validate() const;
};

struct FoundObject {
  int id = 0;
  int area = 0;  // pixels of the scored map
  double iou = 0.0;
  bool found = false;
};

struct ObjectScores {
  std::vector<FoundObject> objects;  // of at least min_area pixels, by id
  int64_t false_objects = 0;
};

// predicted, ids: numbers of objects, 0: none. void_pixels: not 0 where the truth is unknown; may
// be empty. InvalidArgument if sizes differ.
absl::StatusOr<ObjectScores> ScoreObjects(const cv::Mat1i& predicted, const cv::Mat1i& ids,
                                          const cv::Mat1b& void_pixels,
                                          const ObjectOptions& options);

// Ids for masks without numbers: connected components (8 neighbours), from 1.
cv::Mat1i ComponentsOf(const cv::Mat1b& mask);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_OBJECTS_H_
