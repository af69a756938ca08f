// Writes masks in one of the formats of mask_format.h, frame by frame.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "absl/status/status.h"
#include "tools/masks/mask_format.h"

namespace egosieve::tools {

// All pictures have the size and orientation that is stored in their files.
struct MaskedFrame {
  int64_t index = 0;
  std::string image;
  cv::Mat1b masked;
  cv::Mat1w numbers;  // for formats with numbers
  cv::Mat3b picture;  // for kGaussianSplatting
};

class MaskWriter {
 public:
  // sequence: for kMots, "0000" for example.
  MaskWriter(MaskFormat format, std::string folder, std::string sequence)
      : format_(format), folder_(std::move(folder)), sequence_(std::move(sequence)) {}

  // Numbers are at most LargestNumber.
  absl::Status Write(const MaskedFrame& frame);
  // ReducedMaskFile, whose pixels are masked where any of those that they show is.
  absl::Status WriteReduced(const MaskedFrame& frame, int by) const;
  // Writes files that concern all frames, except transforms.json.
  absl::Status Finish();

 private:
  absl::Status WriteFile(const std::string& name, const std::string& bytes) const;
  void AddAnnotations(const MaskedFrame& frame);
  void AddRows(const MaskedFrame& frame);

  MaskFormat format_;
  std::string folder_, sequence_;
  std::string rows_;                                                 // of kMots
  nlohmann::ordered_json images_ = nlohmann::ordered_json::array();  // of kCoco
  nlohmann::ordered_json annotations_ = nlohmann::ordered_json::array();
};

}  // namespace egosieve::tools
