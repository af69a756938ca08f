#include "tools/lab/compare/compare_flags.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "vision/segmentation/methods/map_method.h"

namespace egosieve::tools {

void CompareFlags::AddFlags(CLI::App& app) {
  AddDriveFlags(app);
  AddProfileFlags(app);
}

void CompareFlags::AddDriveFlags(CLI::App& app) {
  methods_ = absl::StrJoin(vision::MethodNames(), ",",
                           [](std::string* out, const vision::MethodName& method) {
                             absl::StrAppend(out, method.name);
                           });
  app.add_option("INPUT", options_.input,
                 "With --truth: a video, a folder or a glob of images; without: a folder of "
                 "sequences, each with frames/ and its truth; left out: synthetic drives alone")
      ->type_name("")
      ->configurable(false);
  app.add_option("--truth", options_.truth,
                 "Masks, a synthetic drive, or tracks.csv, as for evaluate")
      ->type_name("TRUTH");
  app.add_option("--out", options_.out,
                 "Folder for compare.json, compare.csv and the page of plots")
      ->required()
      ->type_name("DIR");
  app.add_option("--methods", methods_, "By commas; the others are compared with the first")
      ->capture_default_str()
      ->type_name("NAMES");
  scenarios_option_ =
      app.add_option("--scenarios", scenarios_,
                     "Synthetic drives to make in OUT/drives, by commas; with a folder of "
                     "sequences they are added to these, where they are asked for")
          ->capture_default_str()
          ->type_name("NAMES");
  app.add_option("--frames", options_.drive_frames, "Frames of each synthetic drive")
      ->check(AtLeast(3))
      ->capture_default_str();
  app.add_option("--max_frames", comparison_.max_frames, "Frames of each drive at most; 0: all")
      ->check(AtLeast<int64_t>(0))
      ->capture_default_str();
  app.add_option("--block", options_.bootstrap.block_frames,
                 "Frames in a row that the bootstrap draws together")
      ->check(AtLeast(1))
      ->capture_default_str();
  app.add_option("--jobs", options_.jobs,
                 "Drives at a time; times per frame are then those of a shared machine")
      ->check(Between(1, 256))
      ->capture_default_str();
}

void CompareFlags::AddProfileFlags(CLI::App& app) {
  app.add_option("--threshold", comparison_.evaluate.scores.threshold,
                 "Probability from which a pixel is called moving, for IoU, F and objects")
      ->check(Between(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--profiles", profiles_,
                 "Profiles of segment, by commas, side by side; --profile alone is one of them")
      ->capture_default_str()
      ->type_name("NAMES");
  app.add_option("--variant", variants_,
                 "One more way to segment, beside the profiles: a name and flags of segment, by "
                 "spaces; may be repeated")
      ->type_name("NAME=FLAGS");
  segment_.AddFlags(app);
  app.get_option("--profile")->excludes(app.get_option("--profiles"));
  profile_option_ = app.get_option("--profile");
}

absl::StatusOr<CompareOptions> CompareFlags::MakeOptions() const {
  CompareOptions options = options_;
  EGOSIEVE_RETURN_IF_ERROR(options.bootstrap.Validate());
  if (options.input.empty() && !options.truth.empty()) {
    return absl::InvalidArgumentError("--truth is given, but no INPUT; give the frames as well");
  }
  if (!options.truth.empty() && scenarios_option_->count() > 0) {
    return absl::InvalidArgumentError(
        "--truth is of one drive, and --scenarios adds drives; leave one of them out");
  }
  options.make_drives = options.input.empty() || scenarios_option_->count() > 0;
  options.scenarios = absl::StrSplit(scenarios_, ',', absl::SkipEmpty());
  if (options.make_drives && options.scenarios.empty()) {
    return absl::InvalidArgumentError("no scenario; name one at least");
  }
  options.drive_seed = segment_.seed();
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<SuiteVariant> variants, Variants());
  if (variants.empty()) return absl::InvalidArgumentError("no profile; name one at least");
  for (const SuiteVariant& variant : variants) {
    const auto has_name = [&](const auto& profile) { return profile.name == variant.name; };
    if (std::any_of(options.profiles.begin(), options.profiles.end(), has_name)) {
      return absl::InvalidArgumentError(
          absl::StrCat("'", variant.name, "' is named twice; names must differ"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(ComparisonOptions comparison, OptionsOf(variant));
    options.profiles.push_back({variant.name, std::move(comparison)});
  }
  return options;
}

absl::StatusOr<std::vector<SuiteVariant>> CompareFlags::Variants() const {
  if (profile_option_->count() == 0) return ParseVariants(profiles_, variants_);
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<SuiteVariant> variants, ParseVariants("", variants_));
  variants.insert(variants.begin(), SuiteVariant{profile_option_->as<std::string>(), {}});
  return variants;
}

absl::StatusOr<ComparisonOptions> CompareFlags::OptionsOf(const SuiteVariant& variant) const {
  SegmentFlags segment = segment_;
  CLI::App app;
  segment.AddFlags(app);
  // CLI11 takes the last argument first.
  std::vector<std::string> arguments(variant.flags.rbegin(), variant.flags.rend());
  try {
    app.parse(arguments);
  } catch (const CLI::Error& error) {
    return absl::InvalidArgumentError(absl::StrCat(variant.name, ": ", error.what()));
  }
  ComparisonOptions comparison = comparison_;
  comparison.methods = absl::StrSplit(methods_, ',', absl::SkipEmpty());
  if (comparison.methods.empty()) {
    return absl::InvalidArgumentError("no method; name one at least");
  }
  comparison.segmenter =
      segment.MakeOptions(std::clamp(kernels::MaximumThreads() / options_.jobs, 1, 256));
  EGOSIEVE_RETURN_IF_ERROR(comparison.segmenter.Validate());
  return comparison;
}

}  // namespace egosieve::tools
