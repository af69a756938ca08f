#include "tools/segment/segment_flags.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "tools/cli/checks.h"
#include "tools/segment/segment_words.h"

namespace egosieve::tools {
namespace {

using vision::OnlineSegmenterOptions;

constexpr int64_t kInputs = 6;  // of a descriptor: place, mean and colours

// An error message; empty for a covariance function that the model supports.
std::string CovarianceError(const std::string& text) {
  const auto function = kernels::CovarianceFunction::Parse(text);
  if (!function.ok()) return std::string(function.status().message());
  const kernels::CovarianceDescription& description = function->description();
  if (description.DimensionOf(description.ScaleCount(kInputs)) == kInputs) return "";
  return absl::StrCat(text, " does not depend on the inputs; add a function that does");
}

CLI::Validator GapOrAutomatic() {
  return CLI::Validator(
      [](std::string& text) { return text == kAutomatic ? std::string() : Between(1, 100)(text); },
      "");
}

CLI::Validator ZeroLabelOrMean() {
  return CLI::Validator(
      [](std::string& text) {
        return text == kMeanLabel ? std::string() : Between(0.01, 0.5)(text);
      },
      "");
}

template <typename Value>
void Override(const std::optional<std::string>& given, const Words<Value>& words, Value& target) {
  for (const auto& [name, value] : words) {
    if (given == name) target = value;
  }
}

template <typename Given, typename Target>
void Override(const std::optional<Given>& given, Target& target) {
  if (given) target = static_cast<Target>(*given);
}

template <typename Value>
void AddWordFlag(CLI::App& app, const std::string& flag, std::optional<std::string>& target,
                 const Words<Value>& words, const std::string& description) {
  const std::vector<std::string> names = NamesOf(words);
  app.add_option(flag, target, description)
      ->check(OneOf(names))
      ->type_name(absl::StrJoin(names, "|"));
}

}  // namespace

void SegmentFlags::AddFlags(CLI::App& app) {
  app.add_option("--profile", profile_,
                 "default: the most accurate; paper: as in the paper's sections III to V; fast: "
                 "default with labels from smaller, neighbouring pictures and with fewer inducing "
                 "points. Flags below override the profile")
      ->check(OneOf(NamesOf(Profiles())))
      ->type_name(absl::StrJoin(NamesOf(Profiles()), "|"));
  app.add_option("--seed", seed_, "Seed of all random numbers")
      ->check(AtLeast<int64_t>(0))
      ->type_name("NUMBER");
  app.add_option("--stride", stride_,
                 "Pixels between neighbouring grid pixels, at which the map is evaluated; 1: all")
      ->check(Between(1, 1000))
      ->type_name("PIXELS");
  app.add_option(
         "--window", window_,
         "Side of the square window over which a descriptor's intensities are averaged; odd")
      ->check(Between(1, 255))
      ->type_name("PIXELS");
  AddModelFlags(app);
  AddLabelFlags(app);
  AddLearnerFlags(app);
}

void SegmentFlags::AddModelFlags(CLI::App& app) {
  AddWordFlag(app, "--model", model_, ModelWords(),
              "exact: the paper's; sparse: through inducing points, with which every pixel "
              "(--stride=1) is affordable");
  app.add_option("--inducing_points", inducing_points_, "Inducing points of --model=sparse at most")
      ->check(Between(int64_t{1}, int64_t{4096}))
      ->type_name("POINTS");
  app.add_option("--budget", budget_, "Points that the model holds at most")
      ->check(Between(int64_t{0}, int64_t{20000}))
      ->type_name("POINTS");
  app.add_option("--density", density_,
                 "Distance between descriptors below which points of one class are thinned; in "
                 "the model 0.7 of it; 0: none are")
      ->check(Between(0.0, 1.0))
      ->type_name("DISTANCE");
  app.add_option("--contradiction_radius", contradiction_radius_,
                 "Distance between descriptors within which a new label drops the model's points "
                 "of the other class; 0: none are; without effect in profile paper")
      ->check(Between(0.0, 1.0))
      ->type_name("DISTANCE");
  app.add_option("--dynamic_age", dynamic_age_, "Frames for which moving points stay in the model")
      ->check(Between(int64_t{0}, kUnlimitedAge))
      ->type_name("FRAMES");
  app.add_option("--arrival_share", arrival_share_,
                 "Largest number of points added per frame, as a share of the budget")
      ->check(Between(0.01, 1.0))
      ->type_name("SHARE");
  app.add_option(
         "--location_prior", location_prior_,
         "Weight of the location prior: where in the image things have moved so far; 0: none")
      ->check(Between(0.0, 1.0))
      ->type_name("WEIGHT");
  app.add_option("--label_residual", label_residual_,
                 "Weight with which the map follows the frame's own labels near them, beside the "
                 "Gaussian process; 0: the Gaussian process alone")
      ->check(Between(0.0, 1.0))
      ->type_name("WEIGHT");
  app.add_flag("--potential", potential_,
               "Also writes potential/: what looks like the things that have moved in the last "
               "minutes, whether it moves or not");
}

void SegmentFlags::AddLabelFlags(CLI::App& app) {
  app.add_option("--frame_gap", frame_gap_,
                 "Frames between the two pictures of a pair; auto: by the measured parallax. Every "
                 "frame has a map")
      ->check(GapOrAutomatic())
      ->type_name("FRAMES|auto");
  app.add_option(
         "--labelling_size", labelling_size_,
         "Longer side to which pictures are reduced before labels are made; 0: they are not")
      ->check(CLI::Validator(
          [](std::string& text) { return text == "0" ? std::string() : Between(64, 65536)(text); },
          ""))
      ->type_name("PIXELS");
  AddWordFlag(app, "--patch_search", patch_search_, SwitchWords(),
              "Search by patches where optical flow fails, for example small crossing cars");
  app.add_option("--focal_ratio", focal_ratio_,
                 "Focal length over the image's longer side; "
                 "overrides --camera, which reads it from a file; estimated in a first pass over "
                 "the drive where neither is given")
      ->check(Between(0.1, 20.0))
      ->type_name("RATIO");
  CLI::Option* ahead =
      app.add_option(
             "--ahead", ahead_,
             "Frames after the current one that its labels may use; 0: none, as for a live camera")
          ->check(Between(0, kMostFramesAhead))
          ->type_name("FRAMES");
  app.add_option(
         "--lag", lag_seconds_,
         "Seconds after the current frame that its labels may look ahead; in place of --ahead")
      ->check(Between(0.0, 10.0))
      ->excludes(ahead)
      ->type_name("SECONDS");
  app.add_option(
         "--evidence", evidence_,
         "What labels rest on: epipolar (the distance from the camera's motion alone), all, "
         "or a list of epipolar, negative_depth, three_view, road, accumulation, own_vehicle")
      ->check(CLI::Validator(
          [](std::string& text) {
            return std::string(vision::ParseEvidenceTerms(text).status().message());
          },
          ""))
      ->type_name("TERMS");
  AddWordFlag(app, "--equalize", equalize_, EqualizationWords(),
              "Luminance equalisation of each frame");
}

void SegmentFlags::AddLearnerFlags(CLI::App& app) {
  app.add_option("--covariance", covariance_,
                 absl::StrCat("Covariance function of the Gaussian process: one of ",
                              absl::StrJoin(kernels::CovarianceFunction::Names(), ", "),
                              "; or of these sums, products and isotropic(...), for example "
                              "\"matern52 + linear * isotropic(periodic)\""))
      ->check(CLI::Validator([](std::string& text) { return CovarianceError(text); }, ""))
      ->type_name("FUNCTION");
  AddWordFlag(app, "--novelty_filter", novelty_filter_, SwitchWords(),
              "Add only those new points that the model misclassifies (the paper's filter 2)");
  AddWordFlag(app, "--consistency_filter", consistency_filter_, SwitchWords(),
              "Drop points that the model misclassifies although it holds them (filter 3)");
  app.add_option("--zero_label", zero_label_,
                 "Label that becomes the target zero, the Gaussian process's prior mean; the "
                 "filters count labels above it as dynamic; mean: the mean label of the model's "
                 "points")
      ->check(ZeroLabelOrMean())
      ->type_name("PROBABILITY|mean");
}

OnlineSegmenterOptions SegmentFlags::MakeOptions(int threads) const {
  OnlineSegmenterOptions options;
  for (const auto& [name, make] : Profiles()) {
    if (name == profile_) options = make();
  }
  options.SetSeed(seed_);
  options.labeller.threads = threads;
  Override(stride_, options.stride_pixels);
  Override(window_, options.descriptor.window_pixels);
  Override(budget_, options.learner.budget.budget);
  if (density_) options.learner.SetDensity(*density_);
  Override(contradiction_radius_, options.learner.contradiction_radius);
  Override(dynamic_age_, options.learner.budget.maximum_positive_age);
  Override(arrival_share_, options.learner.arrival_share);
  Override(location_prior_, options.location_prior.weight);
  Override(label_residual_, options.residual_weight);
  options.potential.enabled = potential_;
  Override(model_, ModelWords(), options.learner.model.kind);
  Override(inducing_points_, options.learner.model.sparse.inducing_points);
  if (frame_gap_ == kAutomatic) {
    options.labeller.frame_gap = kAutomaticGap;
  } else if (frame_gap_.has_value()) {
    options.labeller.frame_gap = std::stoi(*frame_gap_);  // a number, as checked
  }
  Override(labelling_size_, options.labeller.longest_side_pixels);
  Override(patch_search_, SwitchWords(), options.labeller.searches_lost);
  Override(focal_ratio_, options.labeller.focal_ratio);
  Override(ahead_, options.ahead_frames);
  if (evidence_) options.labeller.evidence = *vision::ParseEvidenceTerms(*evidence_);
  Override(equalize_, EqualizationWords(), options.labeller.equalization.method);
  if (covariance_) options.learner.covariance = *kernels::CovarianceFunction::Parse(*covariance_);
  Override(novelty_filter_, SwitchWords(), options.learner.novelty_filter);
  Override(consistency_filter_, SwitchWords(), options.learner.consistency_filter);
  if (zero_label_) {
    options.learner.scales_to_mean_zero = zero_label_ == kMeanLabel;
    if (zero_label_ != kMeanLabel) options.learner.zero_label = std::stod(*zero_label_);
  }
  return options;
}

}  // namespace egosieve::tools
