#include <charconv>

#include "absl/strings/str_cat.h"
#include "tools/segment/segment_flags.h"
#include "tools/segment/segment_words.h"

namespace egosieve::tools {
namespace {

using vision::OnlineSegmenterOptions;

// The shortest text that reads back as the same number.
std::string Shortest(double number) {
  char digits[32];
  return std::string(digits, std::to_chars(digits, digits + sizeof(digits), number).ptr);
}

}  // namespace

std::map<std::string, std::string> DescribeOptions(const OnlineSegmenterOptions& options) {
  const vision::FrameLabellerOptions& labeller = options.labeller;
  const vision::OnlineLearnerOptions& learner = options.learner;
  const auto yes_or_no = [](bool value) { return value ? "yes" : "no"; };
  std::map<std::string, std::string> flags = {
      {"stride", absl::StrCat(options.stride_pixels)},
      {"window", absl::StrCat(options.descriptor.window_pixels)},
      {"model", NameOf(ModelWords(), learner.model.kind)},
      {"inducing_points", learner.model.kind == vision::ModelKind::kSparse
                              ? absl::StrCat(learner.model.sparse.inducing_points)
                              : "none"},
      {"budget", absl::StrCat(learner.budget.budget)},
      {"density", absl::StrCat(learner.new_point_density.radius)},
      {"contradiction_radius", absl::StrCat(learner.contradiction_radius)},
      {"dynamic_age", absl::StrCat(std::min(learner.budget.maximum_positive_age, kUnlimitedAge))},
      {"arrival_share", absl::StrCat(learner.arrival_share)},
      {"location_prior", Shortest(options.location_prior.weight)},
      {"label_residual", Shortest(options.residual_weight)},
      {"frame_gap",
       labeller.frame_gap == kAutomaticGap ? kAutomatic : absl::StrCat(labeller.frame_gap)},
      {"labelling_size", absl::StrCat(labeller.longest_side_pixels)},
      {"patch_search", yes_or_no(labeller.searches_lost)},
      {"focal_ratio", Shortest(labeller.focal_ratio)},
      {"ahead", absl::StrCat(options.ahead_frames)},
      {"evidence", vision::Describe(labeller.evidence)},
      {"equalize", NameOf(EqualizationWords(), labeller.equalization.method)},
      {"covariance", std::string(learner.covariance.text())},
      {"novelty_filter", yes_or_no(learner.novelty_filter)},
      {"consistency_filter", yes_or_no(learner.consistency_filter)},
      {"zero_label",
       learner.scales_to_mean_zero ? std::string(kMeanLabel) : absl::StrCat(learner.zero_label)},
      {"seed", absl::StrCat(labeller.seed)},
      // Settings of the profiles that have no flag.
      {"flow_quality", NameOf(FlowQualityWords(), labeller.flow_quality)},
      {"training_points", absl::StrCat(learner.training.subset_size)},
      {"front_end", labeller.is_paper ? "paper" : "default"},
      {"random_start", yes_or_no(learner.random_start)},
  };
  if (options.potential.enabled) flags["potential"] = yes_or_no(true);
  return flags;
}

}  // namespace egosieve::tools
