#include "tools/batch/plan.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/child_process.h"
#include "tools/cli/exit_code.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Names of files may hold bytes that are not UTF-8.
std::string Dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool IsSegment(const BatchTask& task) {
  return !task.arguments.empty() && task.arguments.front() == "segment";
}

// Whether the command's output is there; true if it is many files, which the run's lines name.
bool HasProduct(const BatchTask& task) {
  const fs::path out = task.folder;
  std::vector<fs::path> any;
  if (task.stage == "masks") any = {MasksPath(task.folder)};
  if (task.stage == "refine") any = {out / "reconstruct.json"};
  if (task.stage == "render") any = {out / "overlay.mp4", out / "render"};
  if (task.stage == "report") any = {out / "report.html"};
  std::error_code error;
  return any.empty() || std::any_of(any.begin(), any.end(),
                                    [&](const fs::path& path) { return fs::exists(path, error); });
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

std::string PieceFolder(const std::string& out, size_t piece) {
  return piece <= 1 ? out : absl::StrCat(out, ".pieces/", piece);
}

// piece: from 1; 0: the drive. Empty if the drive has no such piece, and nothing to merge.
std::vector<std::string> ArgumentsOf(const std::string& command, size_t piece,
                                     const BatchDrive& drive) {
  const size_t cuts = drive.cuts.size();
  if (piece > cuts + 1 || (command == "merge" && cuts == 0)) return {};
  std::vector<std::string> words = {command, command == "segment" ? drive.path : drive.out};
  if (command == "segment") words.push_back("--out=" + PieceFolder(drive.out, piece));
  if (command == "masks") words.push_back("--out=" + MasksPath(drive.out));
  if (command == "masks") words.push_back("--overwrite");
  if (command == "segment" || command == "refine") words.push_back("--resume");
  for (size_t i = 2; command == "merge" && i <= cuts + 1; ++i) {
    words.push_back(PieceFolder(drive.out, i));
  }
  if (const auto flags = drive.flags.find(command); flags != drive.flags.end()) {
    words.insert(words.end(), flags->second.begin(), flags->second.end());
  }
  if (piece > 1) {
    const int64_t from = std::max<int64_t>(1, drive.cuts[piece - 2] - kOverlapFrames);
    words.push_back(absl::StrCat("--from=", from));
  }
  if (piece > 0 && piece <= cuts) {
    words.push_back(absl::StrCat("--to=", drive.cuts[piece - 1] - 1));
  }
  words.push_back("--progress=none");
  return words;
}

}  // namespace

bool TaskRecord::is_good() const {
  return exit_code == static_cast<int>(ExitCode::kDone) ||
         exit_code == static_cast<int>(ExitCode::kFramesFailed);
}

std::string BookFolder(const std::string& out) {
  const fs::path path = AbsolutePath(out);
  return (path.parent_path() / "egosieve_logs" / path.filename()).string();
}

std::string MasksPath(const std::string& out) { return out + ".masks"; }

absl::StatusOr<BatchPlan> BatchPlan::Create(std::vector<BatchDrive> drives) {
  size_t cuts = 0;
  std::map<std::string, std::string> paths;  // by run folder
  const std::vector<std::string>& then = drives.front().then;
  for (const BatchDrive& drive : drives) {
    cuts = std::max(cuts, drive.cuts.size());
    if (drive.then != then) {
      return absl::InvalidArgumentError(
          absl::StrCat(drive.out, " and ", drives.front().out,
                       " differ in what follows segment; give them manifests of their own, or one "
                       "`then`"));
    }
    if (const auto [other, is_new] = paths.emplace(drive.out, drive.path); !is_new) {
      return absl::InvalidArgumentError(absl::StrCat(drive.path, " and ", other->second,
                                                     " have the same run folder, ", drive.out));
    }
  }
  BatchPlan plan;
  plan.drives_ = std::move(drives);
  // Adds a stage and returns its number.
  const auto add = [&](const std::string& command, size_t piece, const std::vector<size_t>& needs) {
    for (size_t i = 0; i < plan.drives_.size(); ++i) {
      const BatchDrive& drive = plan.drives_[i];
      BatchTask task = {piece > 0 ? absl::StrCat(command, "_", piece) : command,
                        PieceFolder(drive.out, piece),
                        ArgumentsOf(command, piece, drive),
                        {}};
      for (const size_t stage : needs) task.needs.push_back(plan.Number(stage, i));
      plan.tasks_.push_back(std::move(task));
    }
    return plan.stages() - 1;
  };
  std::vector<size_t> before;
  for (size_t piece = cuts > 0 ? 1 : 0; piece <= (cuts > 0 ? cuts + 1 : 0); ++piece) {
    before.push_back(add("segment", piece, {}));
  }
  if (cuts > 0) before = {add("merge", 0, before)};
  for (const std::string& command : plan.drives_.front().then) {
    const size_t stage = add(command, 0, before);
    if (command == "refine") before = {stage};
  }
  return plan;
}

Json BatchPlan::ToJson() const {
  Json drives = Json::array(), tasks = Json::array();
  for (const BatchDrive& drive : drives_)
    drives.push_back({{"path", drive.path}, {"run", drive.out}});
  for (size_t i = 0; i < tasks_.size(); ++i) {
    const BatchTask& task = tasks_[i];
    tasks.push_back({{"task", i},
                     {"run", task.folder},
                     {"stage", task.stage},
                     {"arguments", task.arguments},
                     {"needs", task.needs}});
  }
  return {{"drives", std::move(drives)}, {"tasks", std::move(tasks)}};
}

std::string BatchPlan::ToText() const { return Dump(ToJson()) + "\n"; }

absl::StatusOr<BatchPlan> BatchPlan::FromText(const std::string& text) {
  BatchPlan plan;
  try {
    const Json json = Json::parse(text);
    for (const Json& drive : json.at("drives")) {
      plan.drives_.push_back({drive.at("path"), drive.at("run")});
    }
    for (const Json& task : json.at("tasks")) {
      plan.tasks_.push_back(
          {task.at("stage"), task.at("run"), task.at("arguments"), task.at("needs")});
      const std::vector<size_t>& needs = plan.tasks_.back().needs;
      if (std::any_of(needs.begin(), needs.end(),
                      [&](size_t needed) { return needed + 1 >= plan.tasks_.size(); })) {
        return absl::InvalidArgumentError("a task needs one that is not before it");
      }
    }
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(error.what());
  }
  if (plan.drives_.empty() || plan.tasks_.size() % plan.drives_.size() != 0) {
    return absl::InvalidArgumentError("its tasks are not the same for all drives");
  }
  return plan;
}

std::string BatchPlan::BookPath(size_t task, const char* suffix) const {
  return absl::StrCat(BookFolder(DriveOf(task).out), "/", tasks_[task].stage, suffix);
}

Json BatchPlan::Key(size_t task) const {
  if (IsSegment(tasks_[task])) {
    const std::string finished = FinishedUtc(tasks_[task].folder);
    return finished.empty() ? Json() : Json(finished);
  }
  Json key = {tasks_[task].arguments};
  for (const size_t needed : tasks_[task].needs) {
    key.push_back(Key(needed));
    if (key.back().is_null()) return {};
  }
  return key;
}

std::optional<TaskRecord> BatchPlan::Record(size_t task) const {
  const std::string text = ReadFile(BookPath(task, ".json")).value_or("");
  try {
    const Json json = Json::parse(text);
    return TaskRecord{json.at("key"), json.at("exit_code"), json.at("seconds"), json.at("reason")};
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

bool BatchPlan::IsDone(size_t task) const {
  if (tasks_[task].arguments.empty()) return true;
  const Json key = Key(task);
  if (key.is_null() || IsSegment(tasks_[task])) return !key.is_null();
  const std::optional<TaskRecord> record = Record(task);
  return record && record->is_good() && record->key == Dump(key) && HasProduct(tasks_[task]);
}

absl::StatusOr<int> BatchPlan::Run(size_t task, const std::string& program, bool to_log,
                                   const std::function<bool()>& stop_requested) const {
  std::vector<std::string> words = tasks_[task].arguments;
  if (words.empty() || (!IsSegment(tasks_[task]) && IsDone(task))) return 0;
  words.insert(words.begin(), program);
  const std::string log = to_log ? BookPath(task, ".log") : "";
  const std::string record = BookPath(task, ".json"), key = Dump(Key(task));
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(BookFolder(DriveOf(task).out)));
  std::error_code error;
  fs::remove(record, error);
  if (error) return absl::UnavailableError(absl::StrCat("cannot remove ", record));
  const auto start = std::chrono::steady_clock::now();
  const absl::StatusOr<int> code = RunChild(words, log, stop_requested);
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
  const Json json = {
      {"key", key}, {"exit_code", exit_code}, {"seconds", seconds.count()}, {"reason", reason}};
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(record, Dump(json) + "\n"));
  return code;
}

}  // namespace egosieve::tools
