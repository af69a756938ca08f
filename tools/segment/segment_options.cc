#include "tools/segment/segment_options.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "tools/cli/checks.h"
#include "tools/cli/research_flag.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

using Kind = SegmentOption::Kind;
using Settings = SegmentSettings;
using vision::OnlineSegmenterOptions;

constexpr int64_t kInputs = 6;              // of a descriptor: place, mean and colours
constexpr int64_t kUnlimitedAge = 1000000;  // frames
constexpr char kAutomatic[] = "auto";       // the labeller chooses the gap itself
constexpr int kAutomaticGap = 0;
constexpr char kMeanLabel[] = "mean";  // of the model's points

// The shortest text that reads back as the same number.
template <typename Number>
std::string ToText(Number number) {
  char digits[32];
  return std::string(digits, std::to_chars(digits, digits + sizeof(digits), number).ptr);
}

CLI::Validator Check(std::function<std::string(std::string&)> error) {
  return CLI::Validator(std::move(error), "");
}

// A number that `check` accepts, or this word.
CLI::Validator NumberOr(const std::string& word, CLI::Validator check) {
  return Check([=](std::string& text) { return text == word ? std::string() : check(text); });
}

std::string CovarianceError(const std::string& text) {
  const auto function = kernels::CovarianceFunction::Parse(text);
  if (!function.ok()) return std::string(function.status().message());
  const kernels::CovarianceDescription& description = function->description();
  if (description.LeastDimension() > kInputs) {
    return absl::StrCat(text, " has column ", description.LeastDimension() - 1, "; there are ",
                        kInputs, " inputs");
  }
  if (description.DimensionOf(description.ScaleCount(kInputs)) == kInputs) return "";
  return absl::StrCat(text, " has no scale for each input; add a function that does");
}

// member: from the settings to the option's value, by reference.
template <typename Member>
SegmentOption Number(Kind kind, std::string name, std::string type, std::string help,
                     CLI::Validator check, Member member) {
  return {kind,
          std::move(name),
          std::move(type),
          std::move(help),
          std::move(check),
          [member](const std::string& text, Settings& s) {
            CLI::detail::lexical_cast(text, member(s));
          },
          [member](const Settings& s) { return ToText(member(s)); }};
}

template <typename Value, typename Member>
SegmentOption Word(Kind kind, std::string name, std::string help, Words<Value> words,
                   Member member) {
  const std::vector<std::string> names = NamesOf(words);
  return {kind,
          std::move(name),
          absl::StrJoin(names, "|"),
          std::move(help),
          OneOf(names),
          [=](const std::string& text, Settings& s) {
            for (const auto& [word, value] : words) {
              if (word == text) member(s) = value;
            }
          },
          [=](const Settings& s) {
            for (const auto& [word, value] : words) {
              if (value == member(s)) return word;
            }
            return std::string();
          }};
}

template <typename Member>
SegmentOption Switch(Kind kind, std::string name, std::string help, Member member) {
  SegmentOption option = Word(kind, std::move(name), std::move(help),
                              Words<bool>{{"on", true}, {"off", false}}, member);
  if (kind == Kind::kFlag) option.type.clear();
  return option;
}

// Not told: run.json has what the file gives.
template <typename Member>
SegmentOption File(Kind kind, std::string name, std::string type, std::string help, Member member) {
  return {kind,
          std::move(name),
          std::move(type),
          std::move(help),
          {},
          [member](const std::string& text, Settings& s) { member(s) = text; },
          [member](const Settings& s) { return member(s); },
          /*is_told=*/false};
}

SegmentOption Untold(SegmentOption option) {
  option.is_told = false;
  return option;
}

std::vector<SegmentOption> MakeOptions() {
  SegmentOption inducing = Number(
      Kind::kResearch, "inducing_points", "POINTS", "Inducing points of the sparse model at most",
      Between(1, 4096),
      [](auto& s) -> auto& { return s.segmenter.learner.model.sparse.inducing_points; });
  inducing.get = [tell = inducing.get](const Settings& s) {
    return s.segmenter.learner.model.kind == vision::ModelKind::kSparse ? tell(s) : "none";
  };
  SegmentOption age = Number(
      Kind::kResearch, "dynamic_age", "FRAMES", "Frames for which moving points stay in the model",
      Between(int64_t{0}, kUnlimitedAge),
      [](auto& s) -> auto& { return s.segmenter.learner.budget.maximum_positive_age; });
  age.get = [](const Settings& s) {
    return ToText(std::min(s.segmenter.learner.budget.maximum_positive_age, kUnlimitedAge));
  };
  return {
      // The map.
      {Kind::kFlag, "seed", "NUMBER", "Seed of all random numbers", AtLeast<int64_t>(0),
       [](const std::string& text, Settings& s) { s.segmenter.SetSeed(std::stoull(text)); },
       [](const Settings& s) { return absl::StrCat(s.segmenter.labeller.seed); }},
      Number(
          Kind::kFlag, "stride", "PIXELS",
          "Pixels between neighbouring grid pixels, at which the map is evaluated; 1: all",
          Between(1, 1000), [](auto& s) -> auto& { return s.segmenter.stride_pixels; }),
      Number(
          Kind::kFlag, "budget", "POINTS", "Points that the model holds at most", Between(0, 20000),
          [](auto& s) -> auto& { return s.segmenter.learner.budget.budget; }),
      Number(
          Kind::kFlag, "ahead", "FRAMES",
          "Frames after the current one that its labels may use; 0: none, as for a live camera",
          Between(0, 100), [](auto& s) -> auto& { return s.segmenter.ahead_frames; }),
      // The camera.
      File(
          Kind::kFlag, "camera", "FILE",
          "The lens: a run's camera.json, or JSON of focal_pixels, width and height; COLMAP's "
          "cameras.txt; camera_info of ROS or Kalibr's camchain (.yaml). Focal length and "
          "distortion are estimated in a first pass over the drive where they are not given",
          [](auto& s) -> auto& { return s.camera.lens; }),
      File(
          Kind::kFlag, "ignore", "MASK",
          "Image of the frames' size: where it is not black, nothing is used for the "
          "camera's motion and nothing is labelled or marked as moving",
          [](auto& s) -> auto& { return s.camera.ignore; }),
      Switch(
          Kind::kFlag, "own_vehicle",
          "Find what is fixed in the image (bonnet, dashboard, time stamp, reflections) in "
          "the first pass",
          [](auto& s) -> auto& { return s.camera.finds_own_vehicle; }),
      Switch(
          Kind::kFlag, "first_pass",
          "Read some pictures of the drive beforehand, for the focal length, the direction of "
          "travel and what is fixed in the image; off: learn the focal length on the way, as for "
          "a live camera",
          [](auto& s) -> auto& { return s.camera.has_first_pass; }),
      // Which frames.
      Number(
          Kind::kFlag, "checkpoint_every", "FRAMES",
          "Frames between checkpoints, from which --resume continues; 0: none", AtLeast<int64_t>(0),
          [](auto& s) -> auto& { return s.schedule.checkpoint_every; }),
      Number(
          Kind::kFlag, "from", "FRAME", "Index of the first frame", AtLeast<int64_t>(0),
          [](auto& s) -> auto& { return s.schedule.range.from; }),
      Untold(Number(
          Kind::kFlag, "to", "FRAME", "Index of the last frame; -1: the last of the drive",
          AtLeast<int64_t>(-1), [](auto& s) -> auto& { return s.schedule.range.to; })),
      Number(
          Kind::kFlag, "skip", "N",
          "Skips N frames between two that are segmented: they are neither learnt from nor mapped",
          AtLeast<int64_t>(0), [](auto& s) -> auto& { return s.schedule.skip; }),
      Number(
          Kind::kFlag, "fps", "RATE",
          "Frames per second of a folder of images: sets their times, skips none", AtLeast(1e-3),
          [](auto& s) -> auto& { return s.schedule.source.nominal_rate_hz; }),
      {Kind::kFlag,
       "times",
       "FILE",
       "The times of the images of a folder or a glob, one per line",
       {},
       [](const std::string& text, Settings& s) { s.schedule.source.times = text; },
       [](const Settings& s) {
         const std::string& times = s.schedule.source.times;
         return times.empty() ? times : AbsolutePath(times);
       }},
      Untold(Number(
          Kind::kFlag, "max_frames", "FRAMES", "Frames to segment at most; 0: no limit",
          AtLeast<int64_t>(0), [](auto& s) -> auto& { return s.schedule.max_frames; })),
      // The model.
      Word(
          Kind::kResearch, "model",
          "exact: the paper's; sparse: through inducing points, with which every pixel "
          "(--stride=1) is affordable",
          Words<vision::ModelKind>{{"exact", vision::ModelKind::kExact},
                                   {"sparse", vision::ModelKind::kSparse}},
          [](auto& s) -> auto& { return s.segmenter.learner.model.kind; }),
      std::move(inducing),
      {Kind::kResearch, "covariance", "FUNCTION",
       absl::StrCat("Covariance function of the Gaussian process: one of ",
                    absl::StrJoin(kernels::CovarianceFunction::Names(), ", "),
                    "; or of these sums, products, isotropic(...) and columns, for example "
                    "'matern52 + linear[0:2] * isotropic(periodic)'"),
       Check(CovarianceError),
       [](const std::string& text, Settings& s) {
         s.segmenter.learner.covariance = *kernels::CovarianceFunction::Parse(text);
       },
       [](const Settings& s) { return std::string(s.segmenter.learner.covariance.text()); }},
      Number(
          Kind::kResearch, "window", "PIXELS",
          "Side of the square window over which a descriptor's intensities are averaged; odd",
          Between(1, 255), [](auto& s) -> auto& { return s.segmenter.window_pixels; }),
      // Its points.
      {Kind::kResearch, "density", "DISTANCE",
       "Distance between descriptors below which points of one class are thinned; in the model 0.7 "
       "of it; 0: none are",
       Between(0.0, 1.0),
       [](const std::string& text, Settings& s) {
         s.segmenter.learner.SetDensity(std::stod(text));
       },
       [](const Settings& s) { return ToText(s.segmenter.learner.new_point_radius); }},
      std::move(age),
      Number(
          Kind::kResearch, "arrival_share", "SHARE",
          "Largest number of points added per frame, as a share of the budget", Between(0.01, 1.0),
          [](auto& s) -> auto& { return s.segmenter.learner.arrival_share; }),
      Switch(
          Kind::kResearch, "novelty_filter",
          "Add only those new points that the model misclassifies (the paper's filter 2)",
          [](auto& s) -> auto& { return s.segmenter.learner.novelty_filter; }),
      Switch(
          Kind::kResearch, "consistency_filter",
          "Drop points that the model misclassifies although it holds them (filter 3)",
          [](auto& s) -> auto& { return s.segmenter.learner.consistency_filter; }),
      {Kind::kResearch, "zero_label", "PROBABILITY|mean",
       "Label that becomes the target zero, the Gaussian process's prior mean; the filters count "
       "labels above it as dynamic; mean: the mean label of the model's points",
       NumberOr(kMeanLabel, Between(0.01, 0.5)),
       [](const std::string& text, Settings& s) {
         s.segmenter.learner.scales_to_mean_zero = text == kMeanLabel;
         if (text != kMeanLabel) s.segmenter.learner.zero_label = std::stod(text);
       },
       [](const Settings& s) {
         const vision::OnlineLearnerOptions& learner = s.segmenter.learner;
         return learner.scales_to_mean_zero ? kMeanLabel : ToText(learner.zero_label);
       }},
      // What is made of its map.
      Number(
          Kind::kResearch, "location_prior", "WEIGHT",
          "Weight of the location prior: where in the image things have moved so far; 0: none",
          Between(0.0, 1.0), [](auto& s) -> auto& { return s.segmenter.location_prior.weight; }),
      Number(
          Kind::kResearch, "label_residual", "WEIGHT",
          "Weight with which the map follows the frame's own labels near them, beside the "
          "Gaussian process; 0: the Gaussian process alone",
          Between(0.0, 1.0), [](auto& s) -> auto& { return s.segmenter.residual_weight; }),
      // Labels.
      File(
          Kind::kResearch, "dump_features", "DIR",
          "The folder for each frame's labels and descriptors as NNNNNN.npz, for other classifiers "
          "(tools/evaluate/compare.py)",
          [](auto& s) -> auto& { return s.features; }),
      {Kind::kResearch, "frame_gap", "FRAMES|auto",
       "Frames between the two pictures of a pair; auto: by the measured parallax",
       NumberOr(kAutomatic, Between(1, 100)),
       [](const std::string& text, Settings& s) {
         s.segmenter.labeller.frame_gap = text == kAutomatic ? kAutomaticGap : std::stoi(text);
       },
       [](const Settings& s) {
         const int gap = s.segmenter.labeller.frame_gap;
         return gap == kAutomaticGap ? kAutomatic : absl::StrCat(gap);
       }},
      Number(
          Kind::kResearch, "labelling_size", "PIXELS",
          "Longer side to which pictures are reduced before labels are made; 0: they are not",
          NumberOr("0", Between(64, 65536)),
          [](auto& s) -> auto& { return s.segmenter.labeller.longest_side_pixels; }),
      Switch(
          Kind::kResearch, "patch_search",
          "Search by patches where optical flow fails, for example small crossing cars",
          [](auto& s) -> auto& { return s.segmenter.labeller.searches_lost; }),
      Number(
          Kind::kResearch, "focal_ratio", "RATIO",
          "Focal length over the image's longer side, in place of --camera; 0: it is not known",
          NumberOr("0", Between(0.1, 20.0)),
          [](auto& s) -> auto& { return s.segmenter.labeller.focal_ratio; }),
      Word(
          Kind::kResearch, "equalize", "Luminance equalisation of each frame",
          Words<vision::Equalization>{{"none", vision::Equalization::kNone},
                                      {"global", vision::Equalization::kGlobal},
                                      {"clahe", vision::Equalization::kClahe}},
          [](auto& s) -> auto& { return s.segmenter.labeller.equalization; }),
      // What a profile alone decides.
      Word(
          Kind::kProfile, "flow_quality", "",
          Words<vision::FlowQuality>{{"ultrafast", vision::FlowQuality::kUltrafast},
                                     {"fast", vision::FlowQuality::kFast},
                                     {"medium", vision::FlowQuality::kMedium}},
          [](auto& s) -> auto& { return s.segmenter.labeller.flow_quality; }),
      Number(
          Kind::kProfile, "training_points", "", "", {},
          [](auto& s) -> auto& { return s.segmenter.learner.training.subset_size; }),
      Word(
          Kind::kProfile, "front_end", "", Words<bool>{{"default", false}, {"paper", true}},
          [](auto& s) -> auto& { return s.segmenter.labeller.is_paper; }),
      Switch(
          Kind::kProfile, "random_start", "",
          [](auto& s) -> auto& { return s.segmenter.learner.random_start; }),
  };
}

const Words<OnlineSegmenterOptions (*)()>& Profiles() {
  static const auto& words =
      *new Words<OnlineSegmenterOptions (*)()>{{"default", &OnlineSegmenterOptions::Default},
                                               {"paper", &OnlineSegmenterOptions::Paper},
                                               {"fast", &OnlineSegmenterOptions::Fast}};
  return words;
}

SegmentSettings SettingsOf(const std::string& profile) {
  SegmentSettings settings;
  for (const auto& [name, make] : Profiles()) {
    if (name == profile) settings.segmenter = make();
  }
  settings.segmenter.SetSeed(1);
  return settings;
}

// The value if no profile has another; else empty.
std::string CommonDefault(const SegmentOption& option) {
  const std::string value = option.get(SettingsOf("default"));
  for (const auto& [name, make] : Profiles()) {
    if (option.get(SettingsOf(name)) != value) return "";
  }
  return value;
}

}  // namespace

vision::PipelineOptions Schedule::MakePipeline(int threads, int64_t first_frame) const {
  vision::PipelineOptions pipeline;
  pipeline.overlap = threads > 1;
  pipeline.first_frame = first_frame;
  pipeline.frame_step = frame_step();
  pipeline.checkpoint_interval = checkpoint_every;
  pipeline.end_frame = range.to >= 0 ? range.to + 1 : -1;
  if (max_frames > 0) {
    const int64_t end = range.from + max_frames * frame_step();
    pipeline.end_frame = pipeline.end_frame < 0 ? end : std::min(pipeline.end_frame, end);
  }
  return pipeline;
}

const std::vector<SegmentOption>& SegmentOptions() {
  static const auto& options = *new std::vector<SegmentOption>(MakeOptions());
  return options;
}

void GivenOptions::AddFlags(CLI::App& app) {
  std::vector<std::string> names;
  for (const SegmentOption& option : SegmentOptions()) {
    if (option.kind != Kind::kProfile) names.push_back(option.name);
  }
  AddFlags(app, names);
  AddSetFlag(app);
}

void GivenOptions::AddFlags(CLI::App& app, const std::vector<std::string>& names) {
  app.add_option("--profile", profile_,
                 "default: the most accurate; paper: as in the paper's sections III to V; fast: "
                 "default with labels from smaller, neighbouring pictures and with fewer inducing "
                 "points. What is given beside it overrides the profile")
      ->check(OneOf(NamesOf(Profiles())))
      ->type_name(absl::StrJoin(NamesOf(Profiles()), "|"));
  for (const SegmentOption& option : SegmentOptions()) {
    if (std::find(names.begin(), names.end(), option.name) == names.end()) continue;
    std::string& given = given_[option.name];
    if (option.type.empty()) {
      const bool is_on = CommonDefault(option) == "on";
      app.add_flag_function(
             absl::StrCat("--", option.name, is_on ? ",!--no_" + option.name : ""),
             [&given](int64_t count) { given = count > 0 ? "on" : "off"; }, option.help)
          ->default_str(is_on ? "true" : "")
          ->option_text(is_on ? "(default: on)" : "");
      continue;
    }
    const bool is_research = option.kind == Kind::kResearch;
    app.add_option_function<std::string>(
           absl::StrCat(is_research ? kResearchFlag : "--", option.name),
           [&given](const std::string& text) { given = text; }, option.help)
        ->check(option.check)
        ->type_name(option.type)
        ->default_str(is_research ? option.get(SettingsOf("default")) : CommonDefault(option))
        ->group(is_research ? kResearchTable : "Options");
  }
}

bool GivenOptions::Has(const std::string& name) const {
  const auto given = given_.find(name);
  return given != given_.end() && !given->second.empty();
}

SegmentSettings GivenOptions::MakeSettings() const {
  SegmentSettings settings = SettingsOf(profile_);
  for (const SegmentOption& option : SegmentOptions()) {
    if (Has(option.name)) option.set(given_.at(option.name), settings);
  }
  return settings;
}

std::map<std::string, std::string> DescribeSettings(const SegmentSettings& settings) {
  std::map<std::string, std::string> described;
  for (const SegmentOption& option : SegmentOptions()) {
    const std::string value = option.get(settings);
    if (option.is_told && !value.empty()) described[option.name] = value;
  }
  return described;
}

}  // namespace egosieve::tools
