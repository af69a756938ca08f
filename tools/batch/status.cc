#include "tools/batch/status.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/progress.h"
#include "tools/report/html.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr char kGenerator[] = "<meta name=\"generator\" content=\"egosieve batch\">";
constexpr char kRefresh[] = "<meta http-equiv=\"refresh\" content=\"5\">";

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

// Escapes a path for use in an address.
std::string Address(const std::string& path) {
  std::string address;
  for (const char c : path) {
    if (absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
        absl::StrContains("/._-~", std::string(1, c))) {
      address += c;
    } else {
      absl::StrAppendFormat(&address, "%%%02X", static_cast<unsigned char>(c));
    }
  }
  return address;
}

std::string Links(const fs::path& folder, const std::string& out) {
  const std::vector<std::pair<const char*, fs::path>> products = {
      {"report", fs::path(out) / "report.html"},
      {"overlay", fs::path(out) / "overlay.mp4"},
      {"masks", MasksPath(out)},
      {"logs", BookFolder(out)}};
  std::string links;
  std::error_code error;
  for (const auto& [name, path] : products) {
    if (!fs::exists(path, error)) continue;
    absl::StrAppend(&links, links.empty() ? "" : " &middot; ", "<a href=\"",
                    Address(path.lexically_relative(folder).string()), "\">", name, "</a>");
  }
  return links;
}

// What table and page show of a drive after its state: names of columns, and text.
std::vector<std::pair<const char*, std::string>> Columns(const DriveStatus& drive) {
  return {{"tasks", absl::StrCat(drive.tasks_done, " of ", drive.tasks)},
          {"code", absl::StrCat(drive.exit_code)},
          {"frames", absl::StrCat(drive.frames)},
          {"failed", absl::StrCat(drive.frames_failed)},
          {"time", DescribeDuration(drive.seconds)}};
}

std::string Row(const fs::path& folder, const BatchDrive& entry, const DriveStatus& drive) {
  // A class of the report's style sheet.
  const char* pill = drive.state == "done"                   ? "done"
                     : absl::EndsWith(drive.state, "failed") ? "failed"
                                                             : "running";
  std::string row =
      absl::StrCat("<tr><td>", EscapeHtml(fs::path(entry.out).filename().string()),
                   "<div class=\"note\">", EscapeHtml(entry.path),
                   "</div></td><td><span class=\"pill ", pill, "\">", drive.state, "</span></td>");
  for (const auto& [name, text] : Columns(drive)) {
    absl::StrAppend(&row, "<td class=\"number\">", text, "</td>");
  }
  return absl::StrCat(row, "<td>", Links(folder, entry.out), "<div class=\"note\">",
                      EscapeHtml(drive.reason), "</div></td></tr>\n");
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
  const std::string page = FindPage(plan).value_or("");
  if (!page.empty()) absl::StrAppend(&table, "\npage of all drives: ", page);
  result.Tell("batch", {{"drives", told}, {"page", page}}, table + "\n");
}

absl::StatusOr<std::string> FindPage(const BatchPlan& plan) {
  fs::path common = fs::path(plan.drives().front().out).parent_path();
  for (const BatchDrive& entry : plan.drives()) {
    while (*fs::path(entry.out).lexically_relative(common).begin() == "..") {
      common = common.parent_path();
    }
  }
  std::string path = (common / "batch.html").string();
  std::error_code error;
  if (!fs::exists(path, error) || absl::StrContains(ReadFile(path).value_or(""), kGenerator)) {
    return path;
  }
  return absl::AlreadyExistsError(absl::StrCat(path, " is no page of a batch; move it away"));
}

absl::Status WritePage(const BatchPlan& plan, const std::vector<DriveStatus>& drives) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string path, FindPage(plan));
  std::map<std::string, int> counts;
  for (const DriveStatus& drive : drives) ++counts[drive.state];
  std::string html = absl::StrCat(
      PageHead("egosieve batch",
               absl::StrCat(PageStyle(),
                            "table{margin-top:24px}td:first-child{min-width:14em}"
                            ".pill{margin-left:0;white-space:nowrap}"),
               absl::StrCat(kGenerator, counts.count("running") > 0 ? kRefresh : "")),
      "<main><header><h1>Drives</h1><p>", drives.size(), drives.size() == 1 ? " drive" : " drives");
  for (const auto& [state, count] : counts) absl::StrAppend(&html, ", ", count, " ", state);
  absl::StrAppend(&html, "</p></header>\n<table><thead><tr><th>drive</th><th>state</th>");
  for (const auto& [name, text] : Columns({})) absl::StrAppend(&html, "<th>", name, "</th>");
  absl::StrAppend(&html, "<th>files</th></tr></thead><tbody>\n");
  for (size_t i = 0; i < drives.size(); ++i) {
    absl::StrAppend(&html, Row(fs::path(path).parent_path(), plan.drives()[i], drives[i]));
  }
  return WriteFileAtomically(path, html + "</tbody></table></main></body></html>\n");
}

}  // namespace egosieve::tools
