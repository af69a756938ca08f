// Makes the labeller that the options name. The only place that knows the paper's front end.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "vision/labelling/shot_labeller.h"
#include "vision/labelling/track_labeller.h"
#include "vision/paper/paper_labeller.h"

namespace egosieve::vision {

// InvalidArgument for invalid options.
inline absl::StatusOr<std::unique_ptr<FrameLabeller>> MakeFrameLabeller(
    const FrameLabellerOptions& options) {
  if (options.is_paper) return PaperLabeller::Create(options);
  return options.later_shots.empty() ? TrackLabeller::Create(options)
                                     : ShotLabeller::Create(options);
}

}  // namespace egosieve::vision
