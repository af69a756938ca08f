#include "tools/batch/plan.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/interruption.h"
#include "tools/cli/standard_streams.h"

namespace egosieve::tools {
namespace {

bool Names(const std::vector<std::string>& flags, const std::string& name) {
  return std::any_of(flags.begin(), flags.end(), [&](const std::string& flag) {
    return flag == "--" + name || absl::StartsWith(flag, absl::StrCat("--", name, "="));
  });
}

}  // namespace

BatchPlan::BatchPlan(std::vector<BatchEntry> entries, int shards, int threads)
    : entries_(std::move(entries)), shards_(shards), threads_(threads) {
  stages_.push_back({StageKind::kSegment, 0, "segment", {}});
  PlanStage reconstruct = {StageKind::kReconstruct, 0, "reconstruct", {}};
  for (int shard = 0; shard < shards; ++shard) {
    reconstruct.needs.push_back(stages_.size());
    stages_.push_back(
        {StageKind::kInfer, shard, absl::StrCat("infer ", shard + 1, "/", shards), {0}});
  }
  stages_.push_back(std::move(reconstruct));
  stages_.push_back({StageKind::kReport, 0, "report", {stages_.size() - 1}});
}

std::vector<std::string> BatchPlan::Arguments(size_t stage, size_t drive) const {
  const BatchEntry& entry = entries_[drive];
  std::vector<std::string> arguments;
  switch (stages_[stage].kind) {
    case StageKind::kSegment:
      arguments = {"segment", entry.path, "--out=" + entry.out, "--resume"};
      arguments.insert(arguments.end(), entry.flags.begin(), entry.flags.end());
      if (!Names(entry.flags, "learn_only")) arguments.push_back("--learn_only");
      break;
    case StageKind::kInfer:
      arguments = {"infer", entry.out,
                   absl::StrCat("--shard=", stages_[stage].shard + 1, "/", shards_)};
      break;
    case StageKind::kReconstruct:
      arguments = {"reconstruct", entry.out, "--resume"};
      break;
    case StageKind::kReport:
      return {"report", entry.out};
  }
  if (stages_[stage].kind != StageKind::kSegment) {
    for (const std::string& flag : entry.flags) {
      if (absl::StartsWith(flag, "--device=")) arguments.push_back(flag);
    }
  }
  if (threads_ > 0 && !Names(entry.flags, "threads")) {
    arguments.push_back(absl::StrCat("--threads=", threads_));
  }
  arguments.push_back("--progress=none");
  return arguments;
}

bool BatchPlan::IsDone(size_t stage, const DriveProgress& progress) const {
  switch (stages_[stage].kind) {
    case StageKind::kSegment:
      return progress.is_segmented;
    case StageKind::kInfer:
      return progress.is_segmented && progress.missing_maps[stages_[stage].shard] == 0;
    case StageKind::kReconstruct:
      return progress.is_reconstructed;
    case StageKind::kReport:
      return progress.has_report;
  }
  return false;
}

std::vector<size_t> BatchPlan::UnfinishedDrives() const {
  std::vector<size_t> drives;
  for (size_t drive = 0; drive < entries_.size(); ++drive) {
    const absl::StatusOr<DriveProgress> progress = ReadDriveProgress(entries_[drive].out, shards_);
    bool is_done = progress.ok();
    for (size_t stage = 0; is_done && stage < stages_.size(); ++stage) {
      is_done = IsDone(stage, *progress);
    }
    if (!is_done) drives.push_back(drive);
  }
  return drives;
}

absl::StatusOr<std::vector<std::string>> BatchPlan::ArgumentsOfReadyTask(int64_t task) const {
  if (!(task >= 0 && task < task_count())) {
    return absl::OutOfRangeError(
        absl::StrCat("--task=", task, ": the plan has tasks 0 to ", task_count() - 1));
  }
  const size_t stage = static_cast<size_t>(task) / entries_.size();
  const size_t drive = static_cast<size_t>(task) % entries_.size();
  if (!stages_[stage].needs.empty()) {
    const std::string& out = entries_[drive].out;
    EGOSIEVE_ASSIGN_OR_RETURN(const DriveProgress progress, ReadDriveProgress(out, shards_));
    for (const size_t needed : stages_[stage].needs) {
      if (!IsDone(needed, progress)) {
        return absl::FailedPreconditionError(
            absl::StrCat("the task '", stages_[needed].name, "' of ", out,
                         " is not done; run it first: --task=", TaskNumber(needed, drive)));
      }
    }
  }
  return Arguments(stage, drive);
}

absl::Status BecomeProgram(const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  std::cout.flush();
  std::cerr.flush();
  dup2(StderrDescriptor(), STDERR_FILENO);
  // A signal that comes from here on waits for the program, which catches it.
  HoldInterruptions();
  if (InterruptionRequested()) return absl::CancelledError("interrupted; nothing was begun");
  execv(program.c_str(), pointers.data());
  return absl::UnavailableError(absl::StrCat("cannot start ", program, ": ", std::strerror(errno)));
}

}  // namespace egosieve::tools
