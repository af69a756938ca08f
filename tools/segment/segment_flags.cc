#include "tools/segment/segment_flags.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "tools/cli/checks.h"

namespace egosieve::tools {
namespace {

using vision::OnlineSegmenterOptions;

// The fewest digits that read back as the same number.
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

const Words<vision::FeatureSource>& FeatureWords() {
  static const auto& words =
      *new Words<vision::FeatureSource>{{"sift+corners", vision::FeatureSource::kSiftCorners},
                                        {"flow", vision::FeatureSource::kFlow},
                                        {"both", vision::FeatureSource::kBoth},
                                        {"auto", vision::FeatureSource::kAuto}};
  return words;
}

const Words<vision::MotionModelChoice>& MotionModelWords() {
  static const auto& words = *new Words<vision::MotionModelChoice>{
      {"auto", vision::MotionModelChoice::kAuto},
      {"fundamental", vision::MotionModelChoice::kFundamental},
      {"homography", vision::MotionModelChoice::kHomography},
      {"calibrated", vision::MotionModelChoice::kCalibrated}};
  return words;
}

const Words<vision::LabelRule>& LabelWords() {
  static const auto& words =
      *new Words<vision::LabelRule>{{"scaled_distance", vision::LabelRule::kScaledDistance},
                                    {"scaled_median", vision::LabelRule::kScaledMedian},
                                    {"mixture", vision::LabelRule::kMixture}};
  return words;
}

const Words<vision::Equalization>& EqualizationWords() {
  static const auto& words =
      *new Words<vision::Equalization>{{"none", vision::Equalization::kNone},
                                       {"global", vision::Equalization::kGlobal},
                                       {"clahe", vision::Equalization::kClahe}};
  return words;
}

const Words<vision::ModelKind>& ModelWords() {
  static const auto& words = *new Words<vision::ModelKind>{{"exact", vision::ModelKind::kExact},
                                                           {"sparse", vision::ModelKind::kSparse}};
  return words;
}

const Words<vision::FlowQuality>& FlowQualityWords() {
  static const auto& words =
      *new Words<vision::FlowQuality>{{"ultrafast", vision::FlowQuality::kUltrafast},
                                      {"fast", vision::FlowQuality::kFast},
                                      {"medium", vision::FlowQuality::kMedium}};
  return words;
}

const Words<bool>& SwitchWords() {
  static const auto& words = *new Words<bool>{{"on", true}, {"off", false}};
  return words;
}

const Words<OnlineSegmenterOptions (*)()>& Profiles() {
  static const auto& words =
      *new Words<OnlineSegmenterOptions (*)()>{{"default", &OnlineSegmenterOptions::Default},
                                               {"paper", &OnlineSegmenterOptions::Paper},
                                               {"fast", &OnlineSegmenterOptions::Fast}};
  return words;
}

constexpr int64_t kInputs = 6;  // of a descriptor: place, mean and colours

// Empty for a covariance function that the model can have.
std::string CovarianceError(const std::string& text) {
  const auto function = kernels::CovarianceFunction::Parse(text);
  if (!function.ok()) return std::string(function.status().message());
  const kernels::CovarianceDescription& description = function->description();
  if (description.DimensionOf(description.ScaleCount(kInputs)) == kInputs) return "";
  return absl::StrCat(text, " does not depend on the inputs; add a function that does");
}

// The gap that the labeller chooses by itself.
constexpr char kAutomatic[] = "auto";
constexpr int kAutomaticGap = 0;
constexpr int64_t kUnlimitedAge = 1000000;  // frames

CLI::Validator GapOrAutomatic() {
  return CLI::Validator(
      [](std::string& text) { return text == kAutomatic ? std::string() : Between(1, 100)(text); },
      "");
}

template <typename Value>
std::string NameOf(const Words<Value>& words, Value value) {
  for (const auto& [name, candidate] : words) {
    if (candidate == value) return name;
  }
  return "";
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
  app.add_option(
         "--profile", profile_,
         "default: the most accurate that keeps up; paper: faithful to the paper's sections "
         "III to V; fast: every stage chosen for speed. Flags below override what the profile says")
      ->check(OneOf(NamesOf(Profiles())))
      ->type_name(absl::StrJoin(NamesOf(Profiles()), "|"));
  app.add_option("--seed", seed_, "Of everything random")
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
  app.add_option("--dynamic_age", dynamic_age_,
                 "Frames for which the model keeps points of what moves: it leaves its place")
      ->check(Between(int64_t{0}, kUnlimitedAge))
      ->type_name("FRAMES");
  app.add_option("--arrival_share", arrival_share_,
                 "The most points that one frame brings, as a share of the budget")
      ->check(Between(0.01, 1.0))
      ->type_name("SHARE");
  app.add_option("--location_prior", location_prior_,
                 "How much it counts where in the image things have moved so far; 0: nothing")
      ->check(Between(0.0, 1.0))
      ->type_name("WEIGHT");
  app.add_flag("--potential", potential_,
               "Also writes potential/: what looks like the things that have moved in the last "
               "minutes, whether it moves or not");
  app.add_option("--frame_gap", frame_gap_,
                 "Frames between the two of a pair; auto: by the parallax that is seen. Every "
                 "frame has its map")
      ->check(GapOrAutomatic())
      ->type_name("FRAMES|auto");
  app.add_option("--feature_count", feature_count_,
                 "SIFT features and corners asked for; 0: 7000 at 1242 x 375, by area")
      ->check(Between(0, 1000000))
      ->type_name("NUMBER");
  AddWordFlag(app, "--features", features_, FeatureWords(), "Where labels come from");
  AddWordFlag(app, "--patch_search", patch_search_, SwitchWords(),
              "Search for the places that flow loses: small cars that cross");
  AddWordFlag(
      app, "--motion_model", motion_model_, MotionModelWords(),
      "How the camera's motion is modelled; calibrated: rotation, translation and depths in "
      "one likelihood, for which the focal length is learnt; auto: homography or "
      "fundamental matrix, whichever explains a pair better");
  app.add_option("--focal_ratio", focal_ratio_,
                 "Focal length over the image's longer side, for the calibrated motion model; "
                 "learnt in a first pass over the drive where it is not given")
      ->check(Between(0.1, 20.0))
      ->type_name("RATIO");
  app.add_option("--ahead", ahead_,
                 "Frames behind the current one that its labels may rest on; 0: none, as a live "
                 "camera has it")
      ->check(Between(0, 100))
      ->type_name("FRAMES");
  AddWordFlag(app, "--labels", labels_, LabelWords(),
              "How a feature's distance from the motion model becomes a label; evidence is "
              "epipolar then, unless it is given");
  app.add_option("--evidence", evidence_,
                 "What labels rest on: epipolar (the distance from the motion model alone), all, "
                 "or a list of epipolar, negative_depth, three_view, road, accumulation, own_car")
      ->check(CLI::Validator(
          [](std::string& text) {
            return std::string(vision::ParseEvidenceTerms(text).status().message());
          },
          ""))
      ->type_name("TERMS");
  AddWordFlag(app, "--equalize", equalize_, EqualizationWords(),
              "Luminance equalisation of each frame");
  app.add_option("--covariance", covariance_,
                 absl::StrCat("Covariance function of the Gaussian process: one of ",
                              absl::StrJoin(kernels::CovarianceFunction::Names(), ", "),
                              "; or of these sums, products and isotropic(...), for example "
                              "\"matern52 + linear * isotropic(periodic)\""))
      ->check(CLI::Validator([](std::string& text) { return CovarianceError(text); }, ""))
      ->type_name("FUNCTION");
  AddWordFlag(
      app, "--novelty_filter", novelty_filter_, SwitchWords(),
      "Of new points only those are taken that the model gets wrong (the paper's filter 2)");
  AddWordFlag(app, "--consistency_filter", consistency_filter_, SwitchWords(),
              "Points that the model gets wrong though it holds them are dropped (filter 3)");
  app.add_option("--zero_label", zero_label_,
                 "Label that the process takes for zero, its prior mean: what is above it counts "
                 "as dynamic to the filters")
      ->check(Between(0.01, 0.5))
      ->type_name("PROBABILITY");
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
  Override(dynamic_age_, options.learner.budget.maximum_dynamic_age_frames);
  Override(arrival_share_, options.learner.arrival_share);
  Override(location_prior_, options.location_prior.weight);
  options.potential.enabled = potential_;
  Override(model_, ModelWords(), options.learner.model.kind);
  Override(inducing_points_, options.learner.model.sparse.inducing_points);
  if (frame_gap_ == kAutomatic) {
    options.labeller.frame_gap = kAutomaticGap;
  } else if (frame_gap_.has_value()) {
    options.labeller.frame_gap = std::stoi(*frame_gap_);  // a number, by its check
  }
  Override(feature_count_, options.labeller.feature_count);
  Override(features_, FeatureWords(), options.labeller.features);
  Override(patch_search_, SwitchWords(), options.labeller.searches_lost);
  Override(motion_model_, MotionModelWords(), options.labeller.motion_model);
  Override(focal_ratio_, options.labeller.focal_ratio);
  Override(ahead_, options.ahead_frames);
  Override(labels_, LabelWords(), options.labeller.label_rule);
  if (evidence_) {
    options.labeller.evidence = *vision::ParseEvidenceTerms(*evidence_);
  } else if (labels_) {
    options.labeller.evidence = vision::EvidenceTerms::EpipolarAlone();
  }
  Override(equalize_, EqualizationWords(), options.labeller.equalization.method);
  if (covariance_) options.learner.covariance = *kernels::CovarianceFunction::Parse(*covariance_);
  Override(novelty_filter_, SwitchWords(), options.learner.novelty_filter);
  Override(consistency_filter_, SwitchWords(), options.learner.consistency_filter);
  Override(zero_label_, options.learner.zero_label);
  return options;
}

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
      {"dynamic_age",
       absl::StrCat(std::min(learner.budget.maximum_dynamic_age_frames, kUnlimitedAge))},
      {"arrival_share", absl::StrCat(learner.arrival_share)},
      {"location_prior", Shortest(options.location_prior.weight)},
      {"frame_gap",
       labeller.frame_gap == kAutomaticGap ? kAutomatic : absl::StrCat(labeller.frame_gap)},
      {"feature_count", absl::StrCat(labeller.feature_count)},
      {"features", NameOf(FeatureWords(), labeller.features)},
      {"patch_search", yes_or_no(labeller.searches_lost)},
      {"motion_model", NameOf(MotionModelWords(), labeller.motion_model)},
      {"focal_ratio", Shortest(labeller.focal_ratio)},
      {"ahead", absl::StrCat(options.ahead_frames)},
      {"evidence", vision::Describe(labeller.evidence)},
      {"labels", NameOf(LabelWords(), labeller.label_rule)},
      {"equalize", NameOf(EqualizationWords(), labeller.equalization.method)},
      {"covariance", std::string(learner.covariance.text())},
      {"novelty_filter", yes_or_no(learner.novelty_filter)},
      {"consistency_filter", yes_or_no(learner.consistency_filter)},
      {"zero_label", absl::StrCat(learner.zero_label)},
      {"seed", absl::StrCat(labeller.seed)},
      // What the profiles set and no flag does.
      {"flow_quality", NameOf(FlowQualityWords(), labeller.flow_quality)},
      {"training_points", absl::StrCat(learner.training.subset_size)},
      {"labelled_frame",
       labeller.labelled_side == vision::LabelledSide::kFirstFrame ? "first" : "current"},
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
  read_word("equalize", EqualizationWords(), options.labeller.equalization.method);
  read_number("stride", options.stride_pixels);
  read_number("window", options.descriptor.window_pixels);
  read_number("location_prior", options.location_prior.weight);
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
