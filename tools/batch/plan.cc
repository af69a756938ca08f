#include "tools/batch/plan.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <iterator>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/drive_files.h"
#include "tools/cli/interruption.h"
#include "tools/cli/standard_streams.h"

namespace egosieve::tools {
namespace {

bool Names(const std::vector<std::string>& flags, const std::string& name) {
  return std::any_of(flags.begin(), flags.end(), [&](const std::string& flag) {
    return flag == "--" + name || absl::StartsWith(flag, absl::StrCat("--", name, "="));
  });
}

bool Names(const std::vector<std::string>& flags, const std::string& name,
           const std::string& value) {
  return std::count(flags.begin(), flags.end(), absl::StrCat("--", name, "=", value)) > 0;
}

// Whether a flag of this name is given and not turned off.
bool Sets(const std::vector<std::string>& flags, const std::string& name) {
  return Names(flags, name) && !Names(flags, name, "false");
}

// The steps after segment, if none are given.
std::vector<BatchStep> DefaultSteps() { return {{"reconstruct", {}}, {"report", {}}}; }

bool IsSegmented(const std::string& run) {
  const absl::StatusOr<DriveProgress> progress = ReadDriveProgress(run);
  return progress.ok() && progress->is_segmented;
}

}  // namespace

absl::Status CheckThen(const std::vector<BatchEntry>& entries) {
  const auto commands = [](const BatchEntry& entry) {
    std::vector<std::string> names;
    for (const BatchStep& step : entry.then) names.push_back(step.command);
    return names;
  };
  for (const BatchEntry& entry : entries) {
    if (commands(entry) != commands(entries.front())) {
      return absl::InvalidArgumentError(absl::StrCat(
          entry.out, " and ", entries.front().out,
          " differ in what follows segment; give them manifests of their own, or one `then`"));
    }
  }
  return absl::OkStatus();
}

BatchPlan::BatchPlan(std::vector<BatchEntry> entries, int threads)
    : entries_(std::move(entries)), threads_(threads) {
  for (BatchEntry& entry : entries_) {
    if (entry.then.empty()) entry.then = DefaultSteps();
    pieces_ = std::max(pieces_, static_cast<int>(entry.cuts.size()) + 1);
  }
  if (pieces_ > 1) {
    std::vector<size_t> learnt;
    for (int piece = 1; piece <= pieces_; ++piece) {
      learnt.push_back(stages_.size());
      stages_.push_back({"segment", piece, absl::StrCat("segment ", piece, "/", pieces_), {}});
    }
    stages_.push_back({"merge", 0, "merge", std::move(learnt)});
  } else {
    stages_.push_back({"segment", 0, "segment", {}});
  }
  size_t before = stages_.size() - 1;
  const std::vector<BatchStep> steps = entries_.empty() ? DefaultSteps() : entries_.front().then;
  for (const BatchStep& step : steps) {
    stages_.push_back({step.command, 0, step.command, {before}});
    if (step.command == "infer" || step.command == "reconstruct") before = stages_.size() - 1;
  }
}

int64_t BatchPlan::LongestPiece(int64_t longest_drive_frames) const {
  int64_t longest = 1;
  for (const BatchEntry& entry : entries_) {
    int64_t begin = 0;
    for (const int64_t cut : entry.cuts) {
      longest = std::max(longest, cut - begin);
      begin = cut - kOverlapFrames;
    }
    longest = std::max(longest, longest_drive_frames - begin);
  }
  return longest;
}

// `piece`: number of the piece, or 0 if no drive is cut.
std::vector<std::string> BatchPlan::SegmentArguments(int piece, const BatchEntry& entry) const {
  std::vector<std::string> arguments = {
      "segment", entry.path, "--out=" + PieceFolder(entry, std::max(1, piece)), "--resume"};
  arguments.insert(arguments.end(), entry.flags.begin(), entry.flags.end());
  if (piece == 0) return arguments;
  const size_t number = static_cast<size_t>(piece);
  if (number > entry.cuts.size() + 1) return {};
  if (piece > 1) {
    arguments.push_back(
        absl::StrCat("--from=", std::max<int64_t>(1, entry.cuts[number - 2] - kOverlapFrames)));
  }
  if (number <= entry.cuts.size()) {
    arguments.push_back(absl::StrCat("--to=", entry.cuts[number - 1] - 1));
  }
  return arguments;
}

std::vector<std::string> BatchPlan::MergeArguments(const BatchEntry& entry) const {
  if (entry.cuts.empty()) return {};
  std::vector<std::string> arguments = {"merge", entry.out};
  for (size_t piece = 2; piece <= entry.cuts.size() + 1; ++piece) {
    arguments.push_back(PieceFolder(entry, static_cast<int>(piece)));
  }
  arguments.push_back("--progress=none");
  return arguments;
}

std::vector<std::string> BatchPlan::Arguments(size_t stage, size_t drive) const {
  const BatchEntry& entry = entries_[drive];
  const std::string& command = stages_[stage].command;
  if (command == "merge") return MergeArguments(entry);
  std::vector<std::string> arguments = {command, entry.out};
  if (command == "segment") {
    arguments = SegmentArguments(stages_[stage].piece, entry);
    if (arguments.empty()) return {};
  }
  if (command == "masks") {
    arguments.insert(arguments.end(), {"--out=" + MasksPath(entry), "--overwrite"});
  }
  if (command == "reconstruct") arguments.push_back("--resume");
  const std::vector<std::string> own = StepOf(stage, drive).flags;
  arguments.insert(arguments.end(), own.begin(), own.end());
  if (command == "report") return arguments;
  if (command != "segment" && command != "masks" && !Names(own, "device")) {
    std::copy_if(entry.flags.begin(), entry.flags.end(), std::back_inserter(arguments),
                 [](const std::string& flag) { return absl::StartsWith(flag, "--device="); });
  }
  const bool takes_threads = command != "render" && command != "masks";
  if (takes_threads && threads_ > 0 && !Names(entry.flags, "threads") && !Names(own, "threads")) {
    arguments.push_back(absl::StrCat("--threads=", threads_));
  }
  arguments.push_back("--progress=none");
  return arguments;
}

BatchStep BatchPlan::StepOf(size_t stage, size_t drive) const {
  const std::string& command = stages_[stage].command;
  if (command == "merge") return {command, MergeArguments(entries_[drive])};
  for (const BatchStep& step : entries_[drive].then) {
    if (step.command == command) return step;
  }
  return {command, {}};
}

bool BatchPlan::IsDone(size_t stage, size_t drive, const DriveProgress& progress) const {
  if (Arguments(stage, drive).empty()) return true;
  const std::string& command = stages_[stage].command;
  if (command == "segment" && stages_[stage].piece > 1) {
    return IsSegmented(PieceFolder(entries_[drive], stages_[stage].piece));
  }
  if (!progress.is_segmented) return false;
  return command == "segment" ||
         IsStepDone(entries_[drive], StepOf(stage, drive), progress.finished_utc);
}

absl::Status BatchPlan::NoteDone(int64_t task) const {
  const size_t stage = static_cast<size_t>(task) / entries_.size();
  const size_t drive = static_cast<size_t>(task) % entries_.size();
  if (!IsNoted(stage)) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const DriveProgress progress, ReadDriveProgress(entries_[drive].out));
  return NoteStepDone(entries_[drive], StepOf(stage, drive), progress.finished_utc);
}

std::vector<size_t> BatchPlan::UnfinishedDrives() const {
  std::vector<size_t> drives;
  for (size_t drive = 0; drive < entries_.size(); ++drive) {
    const absl::StatusOr<DriveProgress> progress = ReadDriveProgress(entries_[drive].out);
    bool is_done = progress.ok();
    for (size_t stage = 0; is_done && stage < stages_.size(); ++stage) {
      is_done = IsDone(stage, drive, *progress);
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
  const std::string& out = entries_[drive].out;
  EGOSIEVE_ASSIGN_OR_RETURN(const DriveProgress progress, ReadDriveProgress(out));
  if (Arguments(stage, drive).empty()) return std::vector<std::string>();
  for (const size_t needed : stages_[stage].needs) {
    if (!IsDone(needed, drive, progress)) {
      return absl::FailedPreconditionError(
          absl::StrCat("the task '", stages_[needed].name, "' of ", out,
                       " is not done; run it first: --task=", TaskNumber(needed, drive)));
    }
  }
  if (IsNoted(stage) && IsDone(stage, drive, progress)) return std::vector<std::string>();
  return Arguments(stage, drive);
}

std::string PieceFolder(const BatchEntry& entry, int piece) {
  return piece == 1 ? entry.out : absl::StrCat(entry.out, ".pieces/", piece);
}

absl::Status CheckCuts(const std::vector<BatchEntry>& entries) {
  for (const BatchEntry& entry : entries) {
    for (const char* flag : {"from", "to", "max_frames", "learn_only"}) {
      if (!entry.cuts.empty() && Sets(entry.flags, flag)) {
        return absl::InvalidArgumentError(absl::StrCat(entry.out, " is learnt in pieces, which --",
                                                       flag, " excludes; leave one of them out"));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status BecomeProgram(const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  std::cout.flush();
  std::cerr.flush();
  dup2(StderrDescriptor(), STDERR_FILENO);
  // A signal that arrives from here on is held until the program catches it.
  HoldInterruptions();
  if (InterruptionRequested()) return absl::CancelledError("interrupted; nothing was begun");
  execv(program.c_str(), pointers.data());
  return absl::UnavailableError(absl::StrCat("cannot start ", program, ": ", std::strerror(errno)));
}

}  // namespace egosieve::tools
