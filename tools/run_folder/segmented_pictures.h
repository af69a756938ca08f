// The pictures that a run was made of, read again.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_description.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

// Opens the run's input, or `input` if it is not empty.
absl::StatusOr<std::unique_ptr<vision::FrameSource>> OpenPictures(const RunDescription& description,
                                                                  const std::string& input);

// The line's picture. DataLoss if it is damaged or has another size.
absl::StatusOr<vision::Frame> ReadPicture(const FrameLine& line, vision::FrameSource& source);

// The error for a picture that is not the one that was segmented.
absl::Status OtherPicture(int64_t index, const vision::FrameSource& source);

}  // namespace egosieve::tools
