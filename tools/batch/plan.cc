#include "tools/batch/plan.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/child_process.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool Names(const std::vector<std::string>& flags, const std::string& name) {
  return std::any_of(flags.begin(), flags.end(), [&](const std::string& flag) {
    return flag == "--" + name || absl::StartsWith(flag, absl::StrCat("--", name, "="));
  });
}

// When the run ended with all its frames; empty if it has not.
std::string FinishedUtc(const std::string& out) {
  const absl::StatusOr<RunFolder> folder = RunFolder::Open(out);
  if (!folder.ok()) return "";
  const absl::StatusOr<RunDescription> description = folder->ReadDescription();
  return description.ok() && description->ended == "done" ? description->finished_utc : "";
}

// Whether the command's output is there; true if it is many files, which the run's lines name.
bool HasProduct(const BatchEntry& entry, const std::string& command) {
  const fs::path out = entry.out;
  std::vector<fs::path> any;
  if (command == "masks") any = {MasksPath(entry)};
  if (command == "refine") any = {out / "reconstruct.json"};
  if (command == "render") any = {out / "overlay.mp4", out / "overlay.avi", out / "render"};
  if (command == "report") any = {out / "report.html"};
  return any.empty() || std::any_of(any.begin(), any.end(), [](const fs::path& path) {
           std::error_code error;
           return fs::exists(path, error);
         });
}

// Why a program failed: its last line of error in the log; earlier lines may be warnings.
std::string Reason(const std::string& log, int exit_code) {
  std::string last = exit_code > 128 ? absl::StrCat("ended by signal ", exit_code - 128)
                                     : absl::StrCat("ended with exit code ", exit_code);
  for (absl::string_view line : absl::StrSplit(ReadFile(log).value_or(""), '\n')) {
    if (absl::ConsumePrefix(&line, "egosieve: ")) last = std::string(line);
  }
  return last;
}

std::vector<std::string> FlagsOf(const BatchEntry& entry, const std::string& command) {
  for (const BatchStep& step : entry.then) {
    if (step.command == command) return step.flags;
  }
  return {};
}

std::vector<std::string> MergeArguments(const BatchEntry& entry) {
  if (entry.cuts.empty()) return {};
  std::vector<std::string> arguments = {"merge", entry.out};
  for (size_t piece = 2; piece <= entry.cuts.size() + 1; ++piece) {
    arguments.push_back(PieceFolder(entry, static_cast<int>(piece)));
  }
  arguments.push_back("--progress=none");
  return arguments;
}

absl::Status Check(const BatchEntry& entry, const BatchEntry& first) {
  if (!std::equal(entry.then.begin(), entry.then.end(), first.then.begin(), first.then.end(),
                  [](const auto& a, const auto& b) { return a.command == b.command; })) {
    return absl::InvalidArgumentError(
        absl::StrCat(entry.out, " and ", first.out,
                     " differ in what follows segment; give them manifests of their own, or one "
                     "`then`"));
  }
  for (const char* flag : {"from", "to", "max_frames"}) {
    if (!entry.cuts.empty() && Names(entry.flags, flag)) {
      return absl::InvalidArgumentError(absl::StrCat(entry.out, " is learnt in pieces, which --",
                                                     flag, " excludes; leave one of them out"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

std::string PieceFolder(const BatchEntry& entry, int piece) {
  return piece == 1 ? entry.out : absl::StrCat(entry.out, ".pieces/", piece);
}

std::string BookFolder(const BatchEntry& entry) {
  const fs::path out = AbsolutePath(entry.out);
  return (out.parent_path() / "egosieve_logs" / out.filename()).string();
}

std::string MasksPath(const BatchEntry& entry) { return absl::StrCat(entry.out, ".masks"); }

absl::StatusOr<BatchPlan> BatchPlan::Create(std::vector<BatchEntry> entries) {
  for (BatchEntry& entry : entries) {
    EGOSIEVE_RETURN_IF_ERROR(Check(entry, entries.front()));
    entry.path = AbsolutePath(entry.path);
    entry.out = AbsolutePath(entry.out);
  }
  return BatchPlan(std::move(entries));
}

BatchPlan::BatchPlan(std::vector<BatchEntry> entries) : entries_(std::move(entries)) {
  size_t pieces = 1;
  for (const BatchEntry& entry : entries_) pieces = std::max(pieces, entry.cuts.size() + 1);
  std::vector<size_t> before;
  const auto add = [&](const std::string& command, bool is_needed) {
    stages_.push_back({command, 0, command, before});
    if (is_needed) before = {stages_.size() - 1};
  };
  if (pieces == 1) {
    add("segment", true);
  } else {
    for (size_t i = 0; i < pieces; ++i) {
      stages_.push_back({"segment", static_cast<int>(i) + 1, absl::StrCat("segment_", i + 1), {}});
      before.push_back(i);
    }
    add("merge", true);
  }
  for (const BatchStep& step : entries_.front().then) {
    add(step.command, step.command == "refine");
  }
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
  const std::vector<std::string> own = FlagsOf(entry, command);
  arguments.insert(arguments.end(), own.begin(), own.end());
  if (command == "report") return arguments;
  if ((command == "refine" || command == "render") && !Names(own, "device")) {
    std::copy_if(entry.flags.begin(), entry.flags.end(), std::back_inserter(arguments),
                 [](const std::string& flag) { return absl::StartsWith(flag, "--device="); });
  }
  arguments.push_back("--progress=none");
  return arguments;
}

std::string BatchPlan::BookPath(size_t stage, size_t drive, const char* suffix) const {
  return absl::StrCat(BookFolder(entries_[drive]), "/", stages_[stage].name, suffix);
}

std::string BatchPlan::Key(size_t stage, size_t drive) const {
  const BatchEntry& entry = entries_[drive];
  Json runs = Json::array(), steps = Json::array();
  for (size_t piece = 1; piece <= entry.cuts.size() + 1; ++piece) {
    const std::string finished = FinishedUtc(PieceFolder(entry, static_cast<int>(piece)));
    if (finished.empty()) return "";
    runs.push_back(finished);
  }
  // What was made of other masks is made again, so the key has the flags of the needed steps.
  for (const size_t needed : stages_[stage].needs) {
    if (stages_[needed].command == "refine") steps.push_back(FlagsOf(entry, "refine"));
  }
  steps.push_back(FlagsOf(entry, stages_[stage].command));
  return Json({{"runs", runs}, {"cuts", entry.cuts}, {"flags", steps}})
      .dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<TaskRecord> BatchPlan::Record(size_t stage, size_t drive) const {
  const std::string text = ReadFile(BookPath(stage, drive, ".json")).value_or("");
  try {
    const Json json = Json::parse(text);
    return TaskRecord{json.at("key"), json.at("exit_code"), json.at("seconds"), json.at("reason")};
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

absl::Status BatchPlan::Enter(size_t stage, size_t drive, const TaskRecord& record) const {
  const Json json = {{"key", record.key},
                     {"exit_code", record.exit_code},
                     {"seconds", record.seconds},
                     {"reason", record.reason}};
  return WriteFileAtomically(BookPath(stage, drive, ".json"),
                             json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

bool BatchPlan::IsDone(size_t stage, size_t drive) const {
  const BatchEntry& entry = entries_[drive];
  const PlanStage& asked = stages_[stage];
  if (Arguments(stage, drive).empty()) return true;
  if (asked.command == "segment") {
    return !FinishedUtc(PieceFolder(entry, std::max(1, asked.piece))).empty();
  }
  const std::optional<TaskRecord> record = Record(stage, drive);
  return record && record->is_good() && !record->key.empty() && record->key == Key(stage, drive) &&
         HasProduct(entry, asked.command);
}

std::vector<size_t> BatchPlan::UnfinishedDrives() const {
  std::vector<size_t> drives;
  for (size_t drive = 0; drive < entries_.size(); ++drive) {
    for (size_t stage = 0; stage < stages_.size(); ++stage) {
      if (IsDone(stage, drive)) continue;
      drives.push_back(drive);
      break;
    }
  }
  return drives;
}

std::optional<size_t> BatchPlan::MissingStage(size_t stage, size_t drive) const {
  for (const size_t needed : stages_[stage].needs) {
    if (!IsDone(needed, drive)) return needed;
  }
  return std::nullopt;
}

absl::StatusOr<int> BatchPlan::Run(size_t stage, size_t drive, const std::string& program,
                                   bool to_log, const std::function<bool()>& stop_requested) const {
  std::vector<std::string> words = Arguments(stage, drive);
  if (words.empty() || (stages_[stage].command != "segment" && IsDone(stage, drive))) return 0;
  words.insert(words.begin(), program);
  const std::string log = to_log ? BookPath(stage, drive, ".log") : "";
  const std::string key = Key(stage, drive);
  if (const auto before = Record(stage, drive);
      stages_[stage].command == "refine" && before && before->key == key) {
    words.push_back("--resume");
  }
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(BookFolder(entries_[drive])));
  EGOSIEVE_RETURN_IF_ERROR(Enter(stage, drive, {key, TaskRecord::kBegun, 0.0, ""}));
  const auto start = std::chrono::steady_clock::now();
  const absl::StatusOr<int> code = RunChild({words, {}, log}, stop_requested);
  constexpr int kInterrupted = static_cast<int>(ExitCode::kInterrupted);
  // 143: the signal came before the program could catch it.
  if (code.ok() && (*code == kInterrupted || (*code == 143 && stop_requested()))) {
    return kInterrupted;
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  const int exit_code = code.ok() ? *code : static_cast<int>(ExitCodeForStatus(code.status()));
  const std::string reason = !code.ok()       ? std::string(code.status().message())
                             : exit_code != 0 ? Reason(log, exit_code)
                                              : "";
  EGOSIEVE_RETURN_IF_ERROR(Enter(stage, drive, {key, exit_code, seconds.count(), reason}));
  return code;
}

}  // namespace egosieve::tools
