// A folder of masks as truth: which mask belongs to which frame, and the meaning of its pixels.
//
//   pixel   0 static, 128 void (unknown), else dynamic; a pixel of a colour mask is dynamic if
//           any channel is not 0 (void: all channels 128)
//   frame   by name, if the input was a folder and every mask has the name, without extension, of
//           a frame in it; else by number, if every mask's name has one (its last run of digits)
//           and all differ: NNNNN.png is the mask of the frame with index NNNNN; else by order, if
//           there are as many masks as frames, as far as these are known beforehand: the k-th file
//           in natural order is the mask of the k-th frame
#ifndef EGOSIEVE_TOOLS_MASKS_TRUTH_MASKS_H_
#define EGOSIEVE_TOOLS_MASKS_TRUTH_MASKS_H_

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::tools {

// The paths by frame. `frame_names`: the frames' file names without extension, by index; empty if
// they have none. NotFound if there is no such folder or no image in it; InvalidArgument if masks
// cannot be matched.
absl::StatusOr<std::map<int64_t, std::string>> ListTruthMasks(
    const std::string& folder, const std::vector<std::string>& frame_names);

// The names, without extension, of the images in a folder, in the order of the frames; empty if
// `path` is not a folder.
std::vector<std::string> FrameNames(const std::string& path);

enum TruthPixel : uint8_t { kTruthStatic = 0, kTruthVoid = 128, kTruthDynamic = 255 };

// 0, 128 or 255 per pixel. DataLoss, naming the file, if it is not an image; OutOfRange if it has
// another size.
absl::StatusOr<cv::Mat1b> ReadTruthMask(const std::string& path, cv::Size expected);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MASKS_TRUTH_MASKS_H_
