// Features of one frame: positions with SIFT descriptors (Lowe, 2004).
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

inline constexpr int kSiftDescriptorBytes = 128;

// The features [0, key_point_count) are SIFT key points, described in their own scale and
// orientation. The rest are corners, described upright at one scale. The two kinds are matched
// separately.
struct FeatureSet {
  std::vector<cv::Point2f> positions;  // pixels, subpixel accuracy, inside the image
  std::vector<uint8_t> descriptors;    // size() x kSiftDescriptorBytes, row-major
  int64_t key_point_count = 0;

  int64_t size() const { return static_cast<int64_t>(positions.size()); }
  const uint8_t* descriptor(int64_t i) const {
    return descriptors.data() + i * kSiftDescriptorBytes;
  }
};

}  // namespace egosieve::vision
