#include <utility>

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {

FrameLabellerOptions FrameLabellerOptions::Paper() {
  FrameLabellerOptions options;
  options.is_paper = true;
  options.equalization = Equalization::kGlobal;
  return options;
}

absl::Status FrameLabellerOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckOptions({
      {"longest_side_pixels", longest_side_pixels,
       longest_side_pixels == 0 || longest_side_pixels >= 64, "be at least 64, or 0"},
      {"frame_gap", frame_gap, frame_gap >= 0 && frame_gap <= 100,
       "be from 1 to 100, or 0 for auto"},
  }));
  if (is_paper && frame_gap == 0) {
    return absl::InvalidArgumentError("the paper's front end needs a frame_gap of at least 1");
  }
  return absl::OkStatus();
}

absl::StatusOr<LabelledFrame> FrameLabeller::Process(const Frame& frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<const ExtractedFrame> extracted, Extract(frame));
  return Label(std::move(extracted));
}

const char* Name(LabelOutcome outcome) {
  switch (outcome) {
    case LabelOutcome::kLabelled:
      return "labelled";
    case LabelOutcome::kNoPair:
      return "no_pair";
    case LabelOutcome::kSizeChanged:
      return "size_changed";
    case LabelOutcome::kTooFewFeatures:
      return "too_few_features";
    case LabelOutcome::kTooFewMatches:
      return "too_few_matches";
    case LabelOutcome::kDuplicateFrame:
      return "duplicate_frame";
    case LabelOutcome::kUntrustedMotion:
      return "untrusted_motion";
  }
  return "unknown";
}

}  // namespace egosieve::vision
