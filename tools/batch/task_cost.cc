#include "tools/batch/task_cost.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/child_process.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/interruption.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/segment/drive_input.h"

namespace egosieve::tools {
namespace {

struct DrivesSeen {
  size_t largest = 0;  // the drive with the largest pictures
  int64_t longest_frames = 0;
};

// A drive that cannot be read counts nothing: its task reports the error.
absl::StatusOr<DrivesSeen> LookAt(const std::vector<BatchEntry>& entries) {
  DrivesSeen seen;
  int64_t most_pixels = 0;
  absl::Status failure;
  for (size_t i = 0; i < entries.size(); ++i) {
    const absl::StatusOr<DriveInput> input = OpenDriveInput(entries[i].path, 0);
    if (!input.ok()) {
      failure.Update(input.status());
      continue;
    }
    const int64_t pixels = static_cast<int64_t>(input->width_pixels) * input->height_pixels;
    if (pixels > most_pixels) {
      most_pixels = pixels;
      seen.largest = i;
    }
    seen.longest_frames = std::max(seen.longest_frames, input->frames->expected_frame_count());
  }
  if (most_pixels == 0) return failure;
  return seen;
}

BatchEntry Piece(BatchEntry entry, const std::string& out, int64_t frames) {
  entry.out = out;
  entry.cuts.clear();
  std::erase_if(entry.flags,
                [](const std::string& flag) { return absl::StartsWith(flag, "--max_frames="); });
  entry.flags.push_back(absl::StrCat("--max_frames=", frames));
  return entry;
}

int64_t PeakMemoryOfChildren() {
  rusage usage = {};
  getrusage(RUSAGE_CHILDREN, &usage);
  return static_cast<int64_t>(usage.ru_maxrss) * 1024;
}

absl::StatusOr<double> SecondsOf(const std::string& program, std::vector<std::string> arguments,
                                 const std::string& log_path) {
  arguments.insert(arguments.begin(), program);
  const auto start = std::chrono::steady_clock::now();
  EGOSIEVE_ASSIGN_OR_RETURN(
      const int code, RunChild({arguments, {}, log_path}, [] { return InterruptionRequested(); }));
  if (InterruptionRequested()) {
    return absl::CancelledError("interrupted while measuring; nothing was submitted");
  }
  if (code != static_cast<int>(ExitCode::kDone) &&
      code != static_cast<int>(ExitCode::kFramesFailed)) {
    const absl::StatusOr<std::string> said = ReadFile(log_path);
    return absl::FailedPreconditionError(absl::StrCat("measuring: 'egosieve ", arguments[1],
                                                      "' ended with exit code ", code, ": ",
                                                      said.value_or("")));
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

absl::StatusOr<BatchCost> MeasureCost(const std::string& program, const BatchPlan& plan,
                                      const std::string& scratch, int64_t frames) {
  EGOSIEVE_ASSIGN_OR_RETURN(const DrivesSeen seen, LookAt(plan.entries()));
  std::error_code error;
  std::filesystem::remove_all(scratch, error);
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(scratch));
  const BatchPlan piece({Piece(plan.entries()[seen.largest], scratch + "/run", frames)},
                        plan.threads());
  BatchCost cost;
  cost.longest_drive_frames = seen.longest_frames;
  for (size_t stage = 0; stage < piece.stages().size(); ++stage) {
    const absl::StatusOr<double> seconds =
        SecondsOf(program, piece.Arguments(stage, 0), scratch + "/log");
    if (!seconds.ok()) {
      std::filesystem::remove_all(scratch, error);
      return seconds.status();
    }
    if (stage == 0) {
      EGOSIEVE_ASSIGN_OR_RETURN(const DriveProgress progress,
                                ReadDriveProgress(piece.entries()[0].out));
      cost.measured_frames = std::max<int64_t>(1, progress.frames);
    }
    cost.seconds_per_frame[piece.stages()[stage].command] =
        *seconds / static_cast<double>(cost.measured_frames);
  }
  cost.peak_memory_bytes = PeakMemoryOfChildren();
  std::filesystem::remove_all(scratch, error);
  return cost;
}

}  // namespace egosieve::tools
