#include "tools/lab/compare/compare_run.h"

#include <filesystem>
#include <mutex>
#include <set>
#include <utility>

#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/interruption.h"
#include "tools/lab/compare/comparison_table.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/segment/segment_flags.h"
#include "tools/suite/sequences.h"
#include "tools/synthesize/synthesize.h"
#include "vision/segmentation/methods/map_method.h"
#include "vision/synthetic/street.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

absl::Status CheckMethods(const std::shared_ptr<kernels::Context>& context,
                          const ComparisonOptions& options) {
  for (const std::string& method : options.methods) {
    const auto made = vision::MakeMethod(method, context, options.segmenter);
    if (!made.ok()) return AsUsageError(made.status());
  }
  return absl::OkStatus();
}

std::string DrivesFolder(const CompareOptions& options) {
  return (fs::path(options.out) / "drives").string();
}

bool MakesDrives(const CompareOptions& options) {
  return options.make_drives && options.input != DrivesFolder(options);
}

SynthesizeOptions DriveOf(const std::string& scenario, const CompareOptions& options) {
  SynthesizeOptions drive;
  drive.scenario = scenario;
  drive.seed = options.drive_seed;
  drive.output_folder = (fs::path(DrivesFolder(options)) / scenario).string();
  drive.overwrite = true;
  drive.rendering.frames = options.drive_frames;
  return drive;
}

absl::Status CheckScenarios(const CompareOptions& options) {
  for (const std::string& scenario : options.scenarios) {
    const SynthesizeOptions drive = DriveOf(scenario, options);
    const auto made = vision::MakeScenario(drive.scenario, drive.seed, drive.rendering);
    if (!made.ok()) return AsUsageError(made.status());
  }
  return absl::OkStatus();
}

// The drives of the scenarios, by name. Other drives in their folder are not among them.
absl::StatusOr<std::vector<Sequence>> MakeDrives(const CompareOptions& options,
                                                 const ProgressFlag& flag) {
  std::vector<Sequence> drives;
  for (const std::string& scenario :
       std::set<std::string>(options.scenarios.begin(), options.scenarios.end())) {
    const SynthesizeOptions drive = DriveOf(scenario, options);
    Progress progress("synthesize", flag, options.drive_frames);
    EGOSIEVE_RETURN_IF_ERROR(
        Synthesize(drive, [&](int, int) { return progress.AdvanceUninterrupted(); }));
    EGOSIEVE_ASSIGN_OR_RETURN(const SequenceList made, FindSequences(drive.output_folder));
    drives.insert(drives.end(), made.sequences.begin(), made.sequences.end());
  }
  return drives;
}

absl::StatusOr<std::vector<Sequence>> Drives(const CompareOptions& options,
                                             const ProgressFlag& progress) {
  if (!options.truth.empty()) {
    fs::path path = fs::absolute(options.input).lexically_normal();
    if (path.filename().empty() || path.filename() == "frames") path = path.parent_path();
    return std::vector<Sequence>{{path.filename().string(), "", options.input, options.truth}};
  }
  std::vector<Sequence> drives;
  if (!options.input.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(SequenceList list, FindSequences(options.input));
    drives = std::move(list.sequences);
  }
  if (MakesDrives(options)) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<Sequence> made, MakeDrives(options, progress));
    drives.insert(drives.end(), made.begin(), made.end());
  }
  return drives;
}

// Every drive under every profile, some at a time.
std::vector<ProfileComparison> CompareAll(const std::shared_ptr<kernels::Context>& context,
                                          const CompareOptions& options,
                                          const std::vector<Sequence>& drives,
                                          const ProgressFlag& flag) {
  const std::vector<ComparedProfile>& profiles = options.profiles;
  std::vector<ProfileComparison> comparisons;
  for (const ComparedProfile& profile : profiles) {
    comparisons.push_back({profile.name, DescribeOptions(profile.options.segmenter),
                           std::vector<DriveComparison>(drives.size()), ComparisonSummary()});
  }
  Progress progress("compare", flag, -1);
  std::mutex mutex;
  const auto tasks = static_cast<int64_t>(profiles.size() * drives.size());
  kernels::ParallelFor(tasks, {.threads = options.jobs}, [&](int64_t i) {
    if (InterruptionRequested()) return;
    const Sequence& sequence = drives[i / profiles.size()];
    const size_t profile = i % profiles.size();
    DriveComparison& result = comparisons[profile].drives[i / profiles.size()];
    absl::StatusOr<DriveComparison> drive =
        CompareMethods(context, sequence, profiles[profile].options, [&] {
          const std::lock_guard lock(mutex);
          return progress.AdvanceUninterrupted();
        });
    if (drive.ok()) {
      result = *std::move(drive);
    } else {
      result.sequence = sequence;
      result.status = drive.status();
    }
  });
  return comparisons;
}

}  // namespace

absl::StatusOr<std::vector<ProfileComparison>> RunComparison(
    const std::shared_ptr<kernels::Context>& context, const CompareOptions& options,
    const ProgressFlag& progress) {
  // Before any long computation.
  EGOSIEVE_RETURN_IF_ERROR(CheckMethods(context, options.profiles.front().options));
  if (MakesDrives(options)) EGOSIEVE_RETURN_IF_ERROR(CheckScenarios(options));
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(options.out));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<Sequence> drives, Drives(options, progress));
  std::vector<ProfileComparison> comparisons = CompareAll(context, options, drives, progress);
  if (InterruptionRequested()) return absl::CancelledError("interrupted; nothing was written");
  if (drives.size() == 1) EGOSIEVE_RETURN_IF_ERROR(comparisons[0].drives[0].status);
  for (ProfileComparison& comparison : comparisons) {
    comparison.summary = Summarise(comparison.drives, options.bootstrap);
  }
  return comparisons;
}

}  // namespace egosieve::tools
