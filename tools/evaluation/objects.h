// Which objects were found, and what was called an object that is none.
//
// Truth gives every pixel an object id (0: none); the prediction is a mask. Its connected
// components (8 neighbours) are the predicted objects. A component may cover several neighbouring
// objects, so each of its pixels is charged to the truth object that is nearest to it:
//
//   IoU(o) = |P and o| / |o or { p in components that touch o : nearest(p) = o }| (1) found(o):
//   IoU(o) >= iou_threshold false object: a component of at least min_area pixels, less than
//   `min_overlap` of whose pixels
//                 lie on objects (or on void pixels)
//
// Objects and components below min_area pixels (of the map that is scored: grid or full) are not
// counted as missed or false; their pixels still are what they are.
#ifndef EGOSIEVE_TOOLS_EVALUATION_OBJECTS_H_
#define EGOSIEVE_TOOLS_EVALUATION_OBJECTS_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::tools {

struct ObjectOptions {
  double iou_threshold = 0.5;
  int min_area = 4;          // pixels of the scored map
  double min_overlap = 0.1;  // of a component that is no false object

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

// prediction: non-zero where called dynamic. ids: CV_32SC1, 0: no object. void_pixels: non-zero
// where the truth does not say; may be empty. InvalidArgument where sizes differ.
absl::StatusOr<ObjectScores> ScoreObjects(const cv::Mat1b& prediction, const cv::Mat1i& ids,
                                          const cv::Mat1b& void_pixels,
                                          const ObjectOptions& options);

// Ids for masks that do not tell objects apart: connected components (8 neighbours), from 1.
cv::Mat1i ComponentsOf(const cv::Mat1b& mask);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_OBJECTS_H_
