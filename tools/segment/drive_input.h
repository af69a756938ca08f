// The input of a drive, opened and checked.
#pragma once

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
  bool is_live = false;  // frames that come only once (vision/frame/video_file.h)
};

// A number, as text, that differs between images.
std::string Fingerprint(const cv::Mat& image);

// Reads from frame `from` on to the first frame that is not damaged. Every error is one of the
// input (DataLoss): it does not exist, cannot be read, or has too few frames for `from`.
absl::StatusOr<DriveInput> OpenDriveInput(const std::string& path, int64_t from,
                                          const vision::FrameSourceOptions& options = {});
// The same for a stream's address: reads its first frame, which remains the next one.
absl::StatusOr<DriveInput> OpenLiveInput(const std::string& address);

// Between the first two frames from `from` on that can be read; 0 where there are no two. The next
// frame of the source stays the same. Errors are the source's.
absl::StatusOr<double> SecondsPerFrame(vision::FrameSource& frames, int64_t from);

}  // namespace egosieve::tools
