#include "tools/compare/compare_command.h"

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/compare/comparison_figures.h"
#include "tools/compare/comparison_table.h"
#include "tools/compare/drive_comparison.h"
#include "tools/compare/profile_comparison.h"
#include "tools/plots/plots_flag.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/segment/segment_flags.h"
#include "tools/suite/sequences.h"
#include "tools/suite/suite_run.h"
#include "tools/synthesize/synthesize.h"
#include "vision/segmentation/methods/map_method.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

std::string AllMethods() {
  return absl::StrJoin(vision::MethodNames(), ",",
                       [](std::string* out, const vision::MethodName& method) {
                         absl::StrAppend(out, method.name);
                       });
}

// Options of one variant of segment.
struct NamedOptions {
  std::string name;
  ComparisonOptions options;
};

class CompareCommand : public Command {
 public:
  std::string name() const override { return "compare"; }
  std::string summary() const override {
    return "Compares the segmenter with other methods on the same features, frames and pixels.";
  }
  std::string example() const override {
    return "egosieve compare drive/frames --truth=drive/masks --out=out/compare\n"
           "egosieve compare sequences --out=out/compare --profile=paper\n"
           "egosieve compare sequences --out=out/compare --profiles=paper "
           "--variant='no_filter_3=--profile=paper --consistency_filter=off'\n"
           "egosieve compare --scenarios=street,junction --frames=60 --out=out/compare";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("INPUT", input_,
                   "With --truth: a video, a folder or a glob of images; without: a folder of "
                   "sequences, each with frames/ and its truth; left out: synthetic drives alone")
        ->type_name("")
        ->configurable(false);
    app.add_option("--truth", truth_, "Masks, a synthetic drive, or tracks.csv, as for evaluate")
        ->type_name("TRUTH");
    app.add_option("--out", out_, "Folder for compare.json, compare.csv and the page of plots")
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
    app.add_option("--frames", synthetic_frames_, "Frames of each synthetic drive")
        ->check(AtLeast(3))
        ->capture_default_str();
    app.add_option("--max_frames", options_.max_frames, "Frames of each drive at most; 0: all")
        ->check(AtLeast<int64_t>(0))
        ->capture_default_str();
    app.add_option("--block", bootstrap_.block_frames,
                   "Frames in a row that the bootstrap draws together")
        ->check(AtLeast(1))
        ->capture_default_str();
    app.add_option("--jobs", jobs_,
                   "Drives at a time; times per frame are then those of a shared machine")
        ->check(Between(1, 256))
        ->capture_default_str();
    app.add_option("--threshold", options_.evaluate.scores.threshold,
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
    device_.AddFlag(app);
    plots_.AddFlag(app);
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_RETURN_IF_ERROR(bootstrap_.Validate());
    options_.methods = absl::StrSplit(methods_, ',', absl::SkipEmpty());
    if (options_.methods.empty()) return absl::InvalidArgumentError("no method; name one at least");
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<NamedOptions> profiles, Profiles());
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    // Check the names before any long computation.
    for (const std::string& method : options_.methods) {
      const auto made =
          vision::MakeMethod(method, device.context, profiles.front().options.segmenter);
      if (!made.ok()) return AsUsageError(made.status());
    }
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder(out_));
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<Sequence> sequences, Sequences());
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<ProfileComparison> comparisons,
                              CompareAll(device.context, profiles, sequences));
    return Report(comparisons);
  }

 private:
  // The profiles and variants, each overridden by the flags that were given to all.
  absl::StatusOr<std::vector<NamedOptions>> Profiles() const {
    std::vector<SuiteVariant> variants;
    if (profile_option_->count() > 0) {
      variants.push_back({profile_option_->as<std::string>(), {}});
    } else {
      for (const std::string& profile :
           std::vector<std::string>(absl::StrSplit(profiles_, ',', absl::SkipEmpty()))) {
        variants.push_back(VariantOfProfile(profile));
      }
    }
    for (const std::string& text : variants_) {
      EGOSIEVE_ASSIGN_OR_RETURN(SuiteVariant variant, ParseVariant(text));
      variants.push_back(std::move(variant));
    }
    if (variants.empty()) return absl::InvalidArgumentError("no profile; name one at least");
    std::vector<NamedOptions> profiles;
    for (const SuiteVariant& variant : variants) {
      const bool known = std::any_of(profiles.begin(), profiles.end(), [&](const auto& profile) {
        return profile.name == variant.name;
      });
      if (known) {
        return absl::InvalidArgumentError(
            absl::StrCat("'", variant.name, "' is named twice; names must differ"));
      }
      EGOSIEVE_ASSIGN_OR_RETURN(ComparisonOptions options, OptionsOf(variant));
      profiles.push_back({variant.name, std::move(options)});
    }
    return profiles;
  }

  absl::StatusOr<ComparisonOptions> OptionsOf(const SuiteVariant& variant) const {
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
    ComparisonOptions options = options_;
    options.segmenter = segment.MakeOptions(std::clamp(kernels::MaximumThreads() / jobs_, 1, 256));
    EGOSIEVE_RETURN_IF_ERROR(options.segmenter.Validate());
    return options;
  }

  absl::StatusOr<std::vector<Sequence>> Sequences() {
    if (input_.empty()) {
      if (!truth_.empty()) {
        return absl::InvalidArgumentError(
            "--truth is given, but no INPUT; give the frames as well");
      }
      EGOSIEVE_RETURN_IF_ERROR(MakeDrives());
      input_ = (fs::path(out_) / "drives").string();
    } else if (!truth_.empty()) {
      fs::path path = fs::absolute(input_).lexically_normal();
      if (path.filename().empty() || path.filename() == "frames") path = path.parent_path();
      return std::vector<Sequence>{{path.filename().string(), "", input_, truth_}};
    }
    EGOSIEVE_ASSIGN_OR_RETURN(SequenceList list, FindSequences(input_));
    const std::string drives = (fs::path(out_) / "drives").string();
    if (input_ != drives && scenarios_option_->count() > 0) {
      EGOSIEVE_RETURN_IF_ERROR(MakeDrives());
      EGOSIEVE_ASSIGN_OR_RETURN(const SequenceList made, FindSequences(drives));
      list.sequences.insert(list.sequences.end(), made.sequences.begin(), made.sequences.end());
    }
    return std::move(list.sequences);
  }

  absl::Status MakeDrives() const {
    for (const std::string& scenario :
         std::vector<std::string>(absl::StrSplit(scenarios_, ',', absl::SkipEmpty()))) {
      SynthesizeOptions options;
      options.scenario = scenario;
      options.seed = segment_.seed();
      options.output_folder = (fs::path(out_) / "drives" / scenario).string();
      options.overwrite = true;
      options.rendering.frames = synthetic_frames_;
      Progress progress("synthesize", progress_, synthetic_frames_);
      EGOSIEVE_RETURN_IF_ERROR(Synthesize(options, [&](int, int) {
        progress.Advance();
        return !InterruptionRequested();
      }));
    }
    return absl::OkStatus();
  }

  // Every drive under every profile, jobs_ at a time.
  absl::StatusOr<std::vector<ProfileComparison>> CompareAll(
      const std::shared_ptr<kernels::Context>& context, const std::vector<NamedOptions>& profiles,
      const std::vector<Sequence>& sequences) {
    std::vector<ProfileComparison> comparisons;
    for (const NamedOptions& profile : profiles) {
      comparisons.push_back({profile.name, DescribeOptions(profile.options.segmenter),
                             std::vector<DriveComparison>(sequences.size()), ComparisonSummary()});
    }
    Progress progress("compare", progress_, -1);
    std::mutex mutex;
    const auto tasks = static_cast<int64_t>(profiles.size() * sequences.size());
    kernels::ParallelFor(tasks, {.threads = jobs_}, [&](int64_t i) {
      if (InterruptionRequested()) return;
      const Sequence& sequence = sequences[i / profiles.size()];
      const size_t profile = i % profiles.size();
      DriveComparison& result = comparisons[profile].drives[i / profiles.size()];
      absl::StatusOr<DriveComparison> drive =
          CompareMethods(context, sequence, profiles[profile].options, [&] {
            const std::lock_guard lock(mutex);
            progress.Advance();
            return !InterruptionRequested();
          });
      if (drive.ok()) {
        result = *std::move(drive);
      } else {
        result.sequence = sequence;
        result.status = drive.status();
      }
    });
    progress.Finish();
    if (InterruptionRequested()) return absl::CancelledError("interrupted; nothing was written");
    if (sequences.size() == 1) EGOSIEVE_RETURN_IF_ERROR(comparisons[0].drives[0].status);
    for (ProfileComparison& comparison : comparisons) {
      comparison.summary = Summarise(comparison.drives, bootstrap_);
    }
    return comparisons;
  }

  absl::StatusOr<ExitCode> Report(const std::vector<ProfileComparison>& comparisons) const {
    nlohmann::ordered_json json = ToJson(comparisons);
    json["block_frames"] = bootstrap_.block_frames;
    const std::string base = absl::StrCat(out_, "/compare");
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(base + ".csv", ToCsv(comparisons)));
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(base + ".json", json.dump(2) + "\n"));
    std::string text = absl::StrCat(ToTable(comparisons), "\n");
    for (const ProfileComparison& comparison : comparisons) {
      for (const std::string& line : CompareWithPaper(comparison.summary)) {
        absl::StrAppend(&text, comparison.profile, ": ", line, "\n");
      }
    }
    int scored = 0, failed = 0;
    for (const ProfileComparison& comparison : comparisons) {
      scored += comparison.summary.drives;
      failed += comparison.summary.failed;
    }
    result_.Tell(name(), {{"drives", scored}, {"failed", failed}, {"scores", base + ".json"}},
                 text);
    if (scored > 0) {
      EGOSIEVE_RETURN_IF_ERROR(
          plots_.Write(absl::StrCat(out_, "/plots"), MakeComparisonPage(comparisons)));
    }
    return failed > 0 ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

  std::string input_, truth_, out_;
  std::string methods_ = AllMethods();
  std::string scenarios_ = "street,junction,crossing,oncoming";
  int synthetic_frames_ = 150;
  int jobs_ = 1;
  std::string profiles_ = "paper,default";
  std::vector<std::string> variants_;
  CLI::Option* profile_option_ = nullptr;
  CLI::Option* scenarios_option_ = nullptr;
  ComparisonOptions options_;  // without the segmenter's, which differ per profile
  BootstrapOptions bootstrap_;
  SegmentFlags segment_;
  DeviceFlag device_;
  ProgressFlag progress_;
  ResultFlag result_;
  PlotsFlag plots_;
};

}  // namespace

std::unique_ptr<Command> MakeCompareCommand() { return std::make_unique<CompareCommand>(); }

}  // namespace egosieve::tools
