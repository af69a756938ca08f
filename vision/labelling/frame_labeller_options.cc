#include "kernels/base/argument_checks.h"
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
  EGOSIEVE_RETURN_IF_ERROR(equalization.Validate());
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckOptions({
      {"longest_side_pixels", longest_side_pixels,
       longest_side_pixels == 0 || longest_side_pixels >= 64, "be at least 64, or 0"},
      {"frame_gap", frame_gap, frame_gap >= 0 && frame_gap <= 100,
       "be from 1 to 100, or 0 for auto"},
  }));
  if (!evidence.IsEnough()) {
    return absl::InvalidArgumentError(
        "evidence has no term that tells movers from the static scene; it needs epipolar, "
        "negative_depth, three_view or road");
  }
  if (!evidence.IsEpipolarAlone() && labelled_side != LabelledSide::kCurrentFrame) {
    return absl::InvalidArgumentError(
        "evidence beyond epipolar needs labelled_side to be the current frame");
  }
  return kernels::CheckOptions({
      {"feature_count", feature_count, feature_count >= 0, "not be negative"},
      {"match_ratio", match_ratio, match_ratio > 0 && match_ratio <= 1, "be in (0, 1]"},
      {"flow_stride_pixels", flow_stride_pixels,
       flow_stride_pixels >= 1 && flow_stride_pixels <= 100, "be from 1 to 100"},
      {"paper_distance_pixels", paper_distance_pixels, kernels::IsPositive(paper_distance_pixels),
       "be positive"},
      {"median_multiple", median_multiple, kernels::IsPositive(median_multiple), "be positive"},
      {"noise_floor_pixels", noise_floor_pixels, kernels::IsPositive(noise_floor_pixels),
       "be positive"},
      {"flow_noise_share", flow_noise_share, kernels::IsNotNegative(flow_noise_share),
       "be finite and not negative"},
      {"minimum_matches", minimum_matches, minimum_matches >= 8, "be at least 8"},
      {"threads", threads, threads >= 1 && threads <= 256, "be from 1 to 256"},
  });
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
