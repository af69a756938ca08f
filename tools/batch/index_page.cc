#include "tools/batch/index_page.h"

#include <algorithm>
#include <filesystem>
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
using State = DriveOutcome::State;

constexpr char kGenerator[] = "<meta name=\"generator\" content=\"egosieve batch\">";
constexpr int kRefreshSeconds = 5;

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

std::string Links(const fs::path& folder, const BatchEntry& entry) {
  const fs::path out = AbsolutePath(entry.out);
  const std::vector<std::pair<const char*, fs::path>> products = {
      {"report", out / "report.html"},
      {"overlay", out / "overlay.mp4"},
      {"masks", MasksPath({"", out.string(), {}, {}})},
      {"movers", out / "tracks.csv"},
      {"run", out / "run.json"},
      {"log", LogPath(entry)}};
  std::string links;
  for (const auto& [name, path] : products) {
    std::error_code error;
    if (!fs::exists(path, error)) continue;
    absl::StrAppend(&links, links.empty() ? "" : " &middot; ", "<a href=\"",
                    Address(path.lexically_relative(folder).string()), "\">", name, "</a>");
  }
  return links;
}

// A class of the report's style sheet.
const char* Pill(State state) {
  switch (state) {
    case State::kDone:
    case State::kWasDone:
      return "done";
    case State::kFailed:
      return "failed";
    case State::kFramesFailed:
    case State::kInterrupted:
    case State::kRunning:
      return "running";
    case State::kNotStarted:
      return "";
  }
  return "";
}

std::string Row(const fs::path& folder, const BatchEntry& entry, const DriveOutcome& outcome) {
  const bool has_ended = outcome.state != State::kNotStarted && outcome.state != State::kRunning;
  std::string state = StateName(outcome.state);
  if (outcome.state == State::kRunning) absl::StrAppend(&state, ": ", outcome.command);
  std::string row = absl::StrCat("<tr><td>", EscapeHtml(fs::path(entry.out).filename().string()),
                                 "<div class=\"note\">", EscapeHtml(entry.path),
                                 "</div></td><td><span class=\"pill ", Pill(outcome.state), "\">",
                                 EscapeHtml(state), "</span></td>");
  if (has_ended) {
    absl::StrAppend(&row, "<td class=\"number\">", outcome.exit_code, "</td><td class=\"number\">",
                    outcome.frames_answered, "</td><td class=\"number\">", outcome.frames_failed,
                    "</td><td class=\"number\">", DescribeDuration(outcome.seconds), "</td>");
  } else {
    absl::StrAppend(&row, "<td></td><td></td><td></td><td></td>");
  }
  absl::StrAppend(&row, "<td>", Links(folder, entry));
  if (!outcome.reason.empty()) {
    absl::StrAppend(&row, "<div class=\"note\">", EscapeHtml(outcome.reason), "</div>");
  }
  return row + "</td></tr>\n";
}

std::string Counts(const std::vector<DriveOutcome>& outcomes) {
  std::string counts = absl::StrCat(outcomes.size(), outcomes.size() == 1 ? " drive" : " drives");
  for (const State state : {State::kDone, State::kWasDone, State::kFramesFailed, State::kFailed,
                            State::kInterrupted, State::kRunning, State::kNotStarted}) {
    const auto count = std::count_if(outcomes.begin(), outcomes.end(),
                                     [&](const DriveOutcome& o) { return o.state == state; });
    if (count > 0) absl::StrAppend(&counts, ", ", count, " ", StateName(state));
  }
  return counts;
}

}  // namespace

std::string DefaultIndexPath(const std::vector<BatchEntry>& entries) {
  fs::path common;
  for (size_t i = 0; i < entries.size(); ++i) {
    const fs::path folder = fs::path(AbsolutePath(entries[i].out)).parent_path();
    if (i == 0) {
      common = folder;
      continue;
    }
    fs::path shared;
    const auto end =
        std::mismatch(common.begin(), common.end(), folder.begin(), folder.end()).first;
    for (auto part = common.begin(); part != end; ++part) shared /= *part;
    common = shared;
  }
  return (common / "batch.html").string();
}

absl::Status CheckIndexPath(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return absl::OkStatus();
  if (!fs::is_regular_file(path, error)) {
    return absl::AlreadyExistsError(absl::StrCat("--index=", path, " is no file; name another"));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  if (absl::StrContains(text, kGenerator)) return absl::OkStatus();
  return absl::AlreadyExistsError(
      absl::StrCat(path, " is no page of a batch; name another by --index=FILE"));
}

std::string IndexPage(const std::string& path, const std::vector<BatchEntry>& entries,
                      const std::vector<DriveOutcome>& outcomes) {
  const fs::path folder = fs::path(AbsolutePath(path)).parent_path();
  const bool is_running = std::any_of(outcomes.begin(), outcomes.end(), [](const DriveOutcome& o) {
    return o.state == State::kRunning;
  });
  std::string html = absl::StrCat(
      PageHead("egosieve batch",
               absl::StrCat(PageStyle(),
                            "table{margin-top:24px}td:first-child{min-width:14em}"
                            ".pill{margin-left:0;white-space:nowrap}"),
               absl::StrCat(kGenerator,
                            is_running ? absl::StrCat("<meta http-equiv=\"refresh\" content=\"",
                                                      kRefreshSeconds, "\">")
                                       : "")),
      "<main><header><h1>Drives</h1><p>", Counts(outcomes),
      "</p></header>\n<table><thead><tr><th>drive</th><th>state</th>",
      "<th class=\"number\">exit code</th><th class=\"number\">answered</th>",
      "<th class=\"number\">failed</th><th class=\"number\">time</th><th>files</th></tr></thead>",
      "<tbody>\n");
  for (size_t i = 0; i < entries.size(); ++i) {
    absl::StrAppend(&html, Row(folder, entries[i], outcomes[i]));
  }
  return absl::StrCat(html, "</tbody></table></main></body></html>\n");
}

}  // namespace egosieve::tools
