// Makes the labeller that the options name. The only place that knows the paper's front end.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "vision/labelling/track_labeller.h"
#include "vision/paper/paper_labeller.h"

namespace egosieve::vision {

// InvalidArgument for invalid options.
inline absl::StatusOr<std::unique_ptr<FrameLabeller>> MakeFrameLabeller(
    const FrameLabellerOptions& options) {
  return options.is_paper ? PaperLabeller::Create(options) : TrackLabeller::Create(options);
}

}  // namespace egosieve::vision
