#include "tools/batch/status.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/progress.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

// NotFound if there is no run yet.
absl::Status CountFrames(const std::string& run, DriveStatus& status) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(run));
  EGOSIEVE_RETURN_IF_ERROR(folder.ReadDescription().status());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  status.frames = static_cast<int64_t>(lines.size());
  status.frames_failed = std::count_if(lines.begin(), lines.end(), [](const FrameLine& line) {
    return line.outcome == FrameLine::Outcome::kFailed;
  });
  return absl::OkStatus();
}

// What the table shows of a drive after its state: names of columns, and text.
std::vector<std::pair<const char*, std::string>> Columns(const DriveStatus& drive) {
  return {{"tasks", absl::StrCat(drive.tasks_done, " of ", drive.tasks)},
          {"code", absl::StrCat(drive.exit_code)},
          {"frames", absl::StrCat(drive.frames)},
          {"failed", absl::StrCat(drive.frames_failed)},
          {"time", DescribeDuration(drive.seconds)}};
}

}  // namespace

DriveStatus StatusOf(const BatchPlan& plan, size_t drive) {
  DriveStatus status;
  const absl::Status run = CountFrames(plan.drives()[drive].out, status);
  if (!absl::IsNotFound(run)) status.state = run.ok() ? "begun" : "failed";
  if (status.state == "failed") status.reason = std::string(run.message());
  for (size_t task = drive; task < plan.tasks().size(); task += plan.drives().size()) {
    if (plan.tasks()[task].arguments.empty()) continue;
    const std::optional<TaskRecord> record = plan.Record(task);
    const bool is_done = plan.IsDone(task);
    ++status.tasks;
    status.tasks_done += is_done;
    if (!record) continue;
    status.seconds += record->seconds;
    if (status.exit_code == 0 && record->exit_code != 0) {
      status.exit_code = record->exit_code;
      const std::string& name = plan.tasks()[task].stage;
      status.reason = name == "segment" ? record->reason : absl::StrCat(name, ": ", record->reason);
    }
    if (!record->is_good() && !is_done) status.state = "failed";
  }
  if (status.tasks_done == status.tasks) {
    status.state = status.exit_code != 0 || status.frames_failed > 0 ? "frames failed" : "done";
  }
  return status;
}

std::vector<DriveStatus> StatusOfAll(const BatchPlan& plan) {
  std::vector<DriveStatus> drives;
  for (size_t i = 0; i < plan.drives().size(); ++i) drives.push_back(StatusOf(plan, i));
  return drives;
}

void TellStatus(const BatchPlan& plan, const std::vector<DriveStatus>& drives,
                const ResultFlag& result) {
  int width = 3;
  for (const BatchDrive& entry : plan.drives()) {
    width = std::max(width, static_cast<int>(entry.out.size()));
  }
  std::string table = absl::StrFormat("%-*s  %13s", width, "run", "state");
  for (const auto& [name, text] : Columns({})) absl::StrAppendFormat(&table, "  %13s", name);
  nlohmann::ordered_json told = nlohmann::ordered_json::array();
  for (size_t i = 0; i < drives.size(); ++i) {
    const DriveStatus& drive = drives[i];
    absl::StrAppendFormat(&table, "\n%-*s  %13s", width, plan.drives()[i].out, drive.state);
    for (const auto& [name, text] : Columns(drive)) absl::StrAppendFormat(&table, "  %13s", text);
    absl::StrAppend(&table, drive.reason.empty() ? "" : "  ", drive.reason);
    told.push_back({{"run", plan.drives()[i].out},
                    {"state", drive.state},
                    {"tasks", drive.tasks},
                    {"tasks_done", drive.tasks_done},
                    {"exit_code", drive.exit_code},
                    {"frames", drive.frames},
                    {"frames_failed", drive.frames_failed},
                    {"seconds", drive.seconds},
                    {"reason", drive.reason}});
  }
  result.Tell("batch", {{"drives", told}}, table + "\n");
}

}  // namespace egosieve::tools
