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
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/drive_job.h"
#include "tools/cli/interruption.h"
#include "tools/cli/standard_streams.h"
#include "tools/run_folder/atomic_file.h"

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
  const absl::StatusOr<DriveProgress> progress = ReadDriveProgress(run, 1);
  return progress.ok() && progress->is_segmented;
}

// Whether the step writes one file per frame and no other file.
bool HasFilesByFrame(const BatchStep& step) {
  if (step.command == "render") return true;
  return step.command == "masks" && !Names(step.flags, "for", "coco") &&
         !Names(step.flags, "for", "mots");
}

}  // namespace

absl::Status CheckThen(const std::vector<BatchEntry>& entries) {
  const auto commands = [](const BatchEntry& entry) {
    std::vector<std::string> names;
    for (const BatchStep& step : entry.then) {
      names.push_back(absl::StrCat(step.command, HasFilesByFrame(step) ? " in shares" : ""));
    }
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

BatchPlan::BatchPlan(std::vector<BatchEntry> entries, int shards, int threads)
    : entries_(std::move(entries)), shards_(shards), threads_(threads) {
  for (BatchEntry& entry : entries_) {
    if (entry.then.empty()) entry.then = DefaultSteps();
    // infer has stages of its own; in a drive's own steps it is not needed.
    std::erase_if(entry.then, [](const BatchStep& step) { return step.command == "infer"; });
  }
  for (const BatchEntry& entry : entries_) {
    pieces_ = std::max(pieces_, static_cast<int>(entry.cuts.size()) + 1);
  }
  if (pieces_ > 1) {
    for (int piece = 1; piece <= pieces_; ++piece) {
      stages_.push_back({"segment", piece, absl::StrCat("segment ", piece, "/", pieces_), {}});
    }
    AddStage("merge", 0, StagesOf("segment"));
  } else {
    AddStage("segment", 0, {});
    for (int shard = 1; shard <= shards_; ++shard) AddStage("infer", shard, {0});
  }
  const std::vector<BatchStep> steps = entries_.empty() ? DefaultSteps() : entries_.front().then;
  for (const BatchStep& step : steps) AddStep(step);
}

void BatchPlan::AddStage(const std::string& command, int shard, std::vector<size_t> needs) {
  const std::string name = shard == 0 ? command : absl::StrCat(command, " ", shard, "/", shards_);
  stages_.push_back({command, shard, name, std::move(needs)});
}

void BatchPlan::AddStep(const BatchStep& step) {
  const std::vector<size_t> masks = StagesOf("reconstruct");
  std::vector<size_t> before =
      masks.empty() ? StagesBeforeSteps() : std::vector<size_t>{masks.back()};
  const bool is_reconstruct = step.command == "reconstruct";
  // Shares of masks need a run that already has its masks.
  const bool is_shared =
      is_reconstruct ||
      (HasFilesByFrame(step) && (step.command != "masks" || !StagesOf("reconstruct").empty()));
  if (shards_ > 1 && is_shared) {
    for (int shard = 1; shard <= shards_; ++shard) AddStage(step.command, shard, before);
    if (!is_reconstruct) return;
    before = StagesOf("reconstruct");
  }
  AddStage(step.command, 0, std::move(before));
}

std::vector<size_t> BatchPlan::StagesOf(const std::string& command) const {
  std::vector<size_t> stages;
  for (size_t stage = 0; stage < stages_.size(); ++stage) {
    if (stages_[stage].command == command) stages.push_back(stage);
  }
  return stages;
}

// The stages that complete the maps.
std::vector<size_t> BatchPlan::StagesBeforeSteps() const {
  return StagesOf(pieces_ > 1 ? "merge" : "infer");
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
  if (piece == 0) {
    std::erase(arguments, "--learn_only=false");  // a plan's maps are made by infer
    if (!Names(arguments, "learn_only")) arguments.push_back("--learn_only");
    return arguments;
  }
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
    arguments = SegmentArguments(stages_[stage].shard, entry);
    if (arguments.empty()) return {};
  }
  if (command == "masks") {
    arguments.insert(arguments.end(), {"--out=" + MasksPath(entry), "--overwrite"});
  }
  if (stages_[stage].shard > 0 && command != "segment") {
    arguments.push_back(absl::StrCat("--shard=", stages_[stage].shard, "/", shards_));
  } else if (command == "reconstruct") {
    arguments.push_back("--resume");
  }
  std::vector<std::string> own;
  for (const BatchStep& step : entry.then) {
    if (step.command == command) own = step.flags;
  }
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

std::string BatchPlan::NotePath(size_t stage, size_t drive) const {
  const std::string name = absl::StrReplaceAll(stages_[stage].name, {{" ", "_"}, {"/", "_of_"}});
  return absl::StrCat(TaskNotesPath(entries_[drive]), "/", name);
}

std::string BatchPlan::Note(size_t stage, size_t drive, const DriveProgress& progress) const {
  return absl::StrCat(progress.finished_utc, " ", absl::StrJoin(Arguments(stage, drive), " "),
                      "\n");
}

bool BatchPlan::IsDone(size_t stage, size_t drive, const DriveProgress& progress) const {
  if (Arguments(stage, drive).empty()) return true;
  const std::string& command = stages_[stage].command;
  if (command == "segment" && stages_[stage].shard > 1) {
    return IsSegmented(PieceFolder(entries_[drive], stages_[stage].shard));
  }
  if (!progress.is_segmented) return false;
  if (command == "segment") return true;
  if (command == "infer") return progress.missing_maps[stages_[stage].shard - 1] == 0;
  return ReadFile(NotePath(stage, drive)).value_or("") == Note(stage, drive, progress);
}

absl::Status BatchPlan::NoteDone(int64_t task) const {
  const size_t stage = static_cast<size_t>(task) / entries_.size();
  const size_t drive = static_cast<size_t>(task) % entries_.size();
  if (!IsNoted(stage)) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const DriveProgress progress,
                            ReadDriveProgress(entries_[drive].out, shards_));
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(TaskNotesPath(entries_[drive])));
  return WriteFileAtomically(NotePath(stage, drive), Note(stage, drive, progress));
}

std::vector<size_t> BatchPlan::UnfinishedDrives() const {
  std::vector<size_t> drives;
  for (size_t drive = 0; drive < entries_.size(); ++drive) {
    const absl::StatusOr<DriveProgress> progress = ReadDriveProgress(entries_[drive].out, shards_);
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
  EGOSIEVE_ASSIGN_OR_RETURN(const DriveProgress progress, ReadDriveProgress(out, shards_));
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
