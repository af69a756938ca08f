// Makes the labeller that the options name. The only place that knows the paper's front end.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {

// InvalidArgument for invalid options.
absl::StatusOr<std::unique_ptr<FrameLabeller>> MakeFrameLabeller(
    const FrameLabellerOptions& options);

}  // namespace egosieve::vision
