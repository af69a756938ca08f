// The user's own masks, which are united with those of the run: pixels that are not 0 are masked.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::tools {

class UserMasks {
 public:
  // path: a picture, used as the mask of every image, or a folder with IMAGE.png, NAME.png or IMAGE
  // itself for some images. NotFound if none of these exists; OutOfRange if the first one is not of
  // `size`. An empty path: no masks.
  static absl::StatusOr<UserMasks> Open(const std::string& path,
                                        const std::vector<std::string>& images, cv::Size size);

  // "3 of 10 images have no mask in DIR"; "" if all have one.
  std::string Describe() const;

  // Adds the image's own mask, if there is one. OutOfRange if its size differs.
  absl::Status AddTo(int64_t index, cv::Mat1b& masked) const;

 private:
  std::string folder_;
  std::vector<std::string> paths_;  // by image; empty if it has none
};

}  // namespace egosieve::tools
