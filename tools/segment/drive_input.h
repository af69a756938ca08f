// The input of a drive, opened and inspected.
#ifndef EGOSIEVE_TOOLS_SEGMENT_DRIVE_INPUT_H_
#define EGOSIEVE_TOOLS_SEGMENT_DRIVE_INPUT_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "tools/run_folder/run_description.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

struct DriveInput {
  std::unique_ptr<vision::FrameSource> frames;
  int width_pixels = 0;  // of the first frame that could be read
  int height_pixels = 0;
  RunDescription::Input description;
  bool is_live = false;  // frames that come once (vision/frame/live_stream.h)
};

// A number that differs for another image, as text.
std::string Fingerprint(const cv::Mat& image);

// Reads on from frame `from` to the first frame that is not damaged. Every error is one of the
// input (DataLoss): nothing there, nothing that can be read, or fewer frames than `from`.
absl::StatusOr<DriveInput> OpenDriveInput(const std::string& path, int64_t from,
                                          const vision::FrameSourceOptions& options = {});
// The same of a stream's address: its first frame, which is the next one.
absl::StatusOr<DriveInput> OpenLiveInput(const std::string& address);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_DRIVE_INPUT_H_
