// A camera's lens, read from a file:
//
//   .txt           COLMAP's cameras.txt (tools/colmap), its first camera
//   .yaml, .yml    ROS's camera_info, with the models plumb_bob, rational_polynomial and equidistant;
//                  what OpenCV's example of calibration writes; or Kalibr's camchain, its first
//                  camera, with pinhole and none, radtan or equi
//   others         JSON: a run's camera.json, or one of width, height and focal_pixels, or fx and fy;
//                  may have cx, cy, k1 to k6, p1, p2 and fisheye (true)
//
// Without distortion and a principal point only the focal length over the longer side counts, so
// that the file may be of pictures of another size and shape.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/geometry/lens.h"

namespace egosieve::tools {

struct LensFile {
  vision::Lens lens;
  cv::Size size;  // of the pictures that it is of

  // No distortion, and the principal point in the middle.
  bool is_pinhole() const {
    return lens.is_pinhole() && lens.cx == 0.5 * size.width && lens.cy == 0.5 * size.height;
  }
  double focal_ratio() const {
    return 0.5 * (lens.fx + lens.fy) / std::max(size.width, size.height);
  }
};

// DataLoss, naming the error.
absl::StatusOr<LensFile> ReadLensFile(const std::string& path);

// The same for the text of a cameras.txt, of YAML and of JSON.
absl::StatusOr<LensFile> LensOfColmap(absl::string_view text);
absl::StatusOr<LensFile> LensOfYaml(absl::string_view text);
absl::StatusOr<LensFile> LensOfJson(absl::string_view text);

// Makes it one of pictures of another size. InvalidArgument if they have another shape.
absl::Status ScaleTo(cv::Size size, LensFile& file);

// The members of JSON that LensOfJson reads; focal_pixels alone of a pinhole camera.
nlohmann::ordered_json JsonOfLens(const LensFile& file);

}  // namespace egosieve::tools
