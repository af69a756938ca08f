// Truth in a folder of `egosieve synthesize`: masks, and objects with their headings.
#ifndef EGOSIEVE_TOOLS_EVALUATION_SYNTHETIC_TRUTH_H_
#define EGOSIEVE_TOOLS_EVALUATION_SYNTHETIC_TRUTH_H_

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "absl/status/statusor.h"

namespace egosieve::tools {

struct SyntheticObject {
  int id = 0;
  std::string object_class;  // car, van, bus, pedestrian, cyclist
  std::string relation;      // standing, ahead, oncoming, crossing
  bool moving = false;
  double distance_metres = 0.0;
  int64_t area_pixels = 0;
};

struct SyntheticTruth {
  std::string folder;
  int width_pixels = 0;
  int height_pixels = 0;
  std::map<int64_t, std::map<int, SyntheticObject>> frames;  // by index, then by id

  // ids/NNNNNN.png. DataLoss, naming the file, if it is not a 16-bit grey image of the drive's
  // size; NotFound if the drive has no such frame.
  absl::StatusOr<cv::Mat1i> ReadIds(int64_t frame) const;
  // The same with the pixels of standing objects set to 0.
  absl::StatusOr<cv::Mat1i> ReadMovingIds(int64_t frame) const;
};

// `folder`: that of the drive, or its masks/. NotFound if there is no scene.json; DataLoss, naming
// the field, if it is damaged.
absl::StatusOr<SyntheticTruth> ReadSyntheticTruth(const std::string& folder);

// Whether `folder`, or its parent if it is masks/, is a synthetic drive.
bool IsSyntheticTruth(const std::string& folder);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_SYNTHETIC_TRUTH_H_
