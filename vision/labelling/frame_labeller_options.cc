#include <cmath>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {

FrameLabellerOptions FrameLabellerOptions::Paper() {
  FrameLabellerOptions options;
  options.features = FeatureSource::kSiftCorners;
  options.motion_model = MotionModelChoice::kFundamental;
  options.label_rule = LabelRule::kScaledDistance;
  options.evidence = EvidenceTerms::EpipolarAlone();
  options.labelled_side = LabelledSide::kFirstFrame;
  options.equalization.method = Equalization::kGlobal;
  options.windowed_search = false;
  options.drop_lone_matches = false;
  return options;
}

absl::Status FrameLabellerOptions::Validate() const {
  const auto error = [](auto... parts) {
    return absl::InvalidArgumentError(absl::StrCat(parts...));
  };
  const auto positive = [&](const char* name, double value) {
    return value > 0 && std::isfinite(value) ? absl::OkStatus()
                                             : error(name, " is ", value, "; it must be positive");
  };
  EGOSIEVE_RETURN_IF_ERROR(equalization.Validate());
  if (longest_side_pixels != 0 && longest_side_pixels < 64) {
    return error("longest_side_pixels is ", longest_side_pixels, "; it must be at least 64, or 0");
  }
  if (frame_gap < 0 || frame_gap > 100) {
    return error("frame_gap is ", frame_gap, "; it must be from 1 to 100, or 0 for auto");
  }
  if (!evidence.IsEnough()) {
    return error(
        "evidence has no term that tells movers from the static scene; it needs epipolar, "
        "negative_depth, three_view or road");
  }
  if (!evidence.IsEpipolarAlone() && labelled_side != LabelledSide::kCurrentFrame) {
    return error("evidence beyond epipolar needs labelled_side to be the current frame");
  }
  if (feature_count < 0)
    return error("feature_count is ", feature_count, "; it must not be negative");
  if (!(match_ratio > 0 && match_ratio <= 1)) {
    return error("match_ratio is ", match_ratio, "; it must be in (0, 1]");
  }
  if (flow_stride_pixels < 1 || flow_stride_pixels > 100) {
    return error("flow_stride_pixels is ", flow_stride_pixels, "; it must be from 1 to 100");
  }
  EGOSIEVE_RETURN_IF_ERROR(positive("paper_distance_pixels", paper_distance_pixels));
  EGOSIEVE_RETURN_IF_ERROR(positive("median_multiple", median_multiple));
  EGOSIEVE_RETURN_IF_ERROR(positive("noise_floor_pixels", noise_floor_pixels));
  if (!(flow_noise_share >= 0.0) || std::isinf(flow_noise_share)) {
    return error("flow_noise_share is ", flow_noise_share, "; it must be finite and not negative");
  }
  if (minimum_matches < 8) {
    return error("minimum_matches is ", minimum_matches, "; it must be at least 8");
  }
  if (threads < 1 || threads > 256) {
    return error("threads is ", threads, "; it must be from 1 to 256");
  }
  return absl::OkStatus();
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
