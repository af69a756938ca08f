#include <algorithm>
#include <charconv>
#include <cstdint>
#include <system_error>

#include "absl/status/status.h"
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

template <typename Number>
bool IsNumber(const std::string& text, Number& number) {
  const char* end = text.data() + text.size();
  const auto [behind, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && behind == end;
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

absl::StatusOr<OnlineSegmenterOptions> ReadInferenceOptions(
    const std::map<std::string, std::string>& flags) {
  OnlineSegmenterOptions options;
  absl::Status status;
  const auto find = [&](const std::string& name) {
    const auto flag = flags.find(name);
    if (flag == flags.end()) {
      status.Update(absl::DataLossError(absl::StrCat("run.json has no flag '", name, "'")));
    }
    return flag == flags.end() ? std::string() : flag->second;
  };
  const auto read_word = [&](const std::string& name, const auto& words, auto& target) {
    const std::string given = find(name);
    for (const auto& [word, value] : words) {
      if (word == given) {
        target = value;
        return;
      }
    }
    status.Update(absl::DataLossError(
        absl::StrCat("run.json's flag '", name, "' has the unknown value '", given, "'")));
  };
  const auto read_number = [&](const std::string& name, auto& target) {
    const std::string given = find(name);
    if (!IsNumber(given, target)) {
      status.Update(absl::DataLossError(
          absl::StrCat("run.json's flag '", name, "' is '", given, "', which is no number")));
    }
  };
  read_word("model", ModelWords(), options.learner.model.kind);
  if (const auto covariance = kernels::CovarianceFunction::Parse(find("covariance"));
      covariance.ok()) {
    options.learner.covariance = *covariance;
  } else {
    status.Update(absl::DataLossError(
        absl::StrCat("run.json's flag 'covariance': ", covariance.status().message())));
  }
  // Checkpoints of such a run hold what the labeller has learnt.
  options.labeller.learns_focal_ratio = find("focal_ratio") == kLearntOnTheWay;
  read_word("equalize", EqualizationWords(), options.labeller.equalization.method);
  read_number("stride", options.stride_pixels);
  read_number("window", options.descriptor.window_pixels);
  read_number("location_prior", options.location_prior.weight);
  read_number("label_residual", options.residual_weight);
  options.potential.enabled = flags.count("potential") > 0;
  uint64_t seed = 1;
  read_number("seed", seed);
  options.SetSeed(seed);
  if (options.learner.model.kind == vision::ModelKind::kSparse) {
    read_number("inducing_points", options.learner.model.sparse.inducing_points);
  }
  if (!status.ok()) return status;
  return options;
}

}  // namespace egosieve::tools
