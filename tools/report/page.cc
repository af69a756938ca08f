#include "tools/report/page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "tools/cli/progress.h"
#include "tools/report/chart.h"
#include "tools/report/embedded_files.h"

namespace egosieve::tools {
namespace {

using Outcome = FrameLine::Outcome;

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<int64_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double TotalMilliseconds(const FrameLine& line) {
  double total = 0.0;
  for (const auto& [stage, milliseconds] : line.milliseconds) {
    total += milliseconds;
  }
  return total;
}

std::string Tile(absl::string_view figure, absl::string_view meaning) {
  return absl::StrCat("<div class=\"tile\"><b>", EscapeHtml(figure), "</b><span>",
                      EscapeHtml(meaning), "</span></div>\n");
}

// The input's last two path components: "car-shadow/frames" says more than "frames".
std::string Title(const RunDescription& description) {
  const std::filesystem::path path(description.input.path);
  return (path.parent_path().filename() / path.filename()).string();
}

std::string Header(const RunDescription& description) {
  const std::string name = Title(description);
  const std::string ended = EscapeHtml(description.ended);
  const std::string label = ended == "running" ? "not finished" : ended;
  std::string html = absl::StrCat("<header><h1>", EscapeHtml(name), " <span class=\"pill ", ended,
                                  "\">", label, "</span></h1>\n");
  absl::StrAppend(&html, "<p>", EscapeHtml(description.input.path), " (", description.grid.width,
                  " &times; ", description.grid.height, ", ", EscapeHtml(description.input.kind),
                  ")</p>\n<p>egosieve ", EscapeHtml(description.version), " on ",
                  EscapeHtml(description.device), "; started ",
                  EscapeHtml(description.started_utc));
  if (!description.finished_utc.empty()) {
    absl::StrAppend(&html, ", ended ", EscapeHtml(description.finished_utc));
  }
  absl::StrAppend(&html, "</p>\n");
  if (!description.ended_message.empty()) {
    absl::StrAppend(&html, "<p><b>", EscapeHtml(description.ended_message), "</b></p>\n");
  }
  return absl::StrCat(html, "</header>\n");
}

std::string Tiles(const ReportContent& content) {
  int64_t learnt = 0, failed = 0;
  std::vector<double> milliseconds, shares;
  for (const FrameLine& line : content.lines) {
    learnt += line.outcome == Outcome::kLearnt;
    failed += line.outcome == Outcome::kFailed;
    milliseconds.push_back(TotalMilliseconds(line));
    if (line.model_size > 0) shares.push_back(line.dynamic_share);
  }
  const int64_t frames = static_cast<int64_t>(content.lines.size());
  std::string html = "<section class=\"tiles\">\n";
  absl::StrAppend(&html, Tile(absl::StrCat(frames - failed), "frames answered"),
                  Tile(absl::StrCat(learnt), "learnt from"), Tile(absl::StrCat(failed), "failed"));
  if (content.evaluation && content.evaluation->pooled_auc) {
    absl::StrAppend(&html, Tile(absl::StrFormat("%.3f", *content.evaluation->pooled_auc),
                                "pooled AUC against the truth"));
  }
  if (frames > 0) {
    // Stages overlap: the clock's time, or the sum of the stages while the run has not ended.
    const double seconds_per_frame = content.description.seconds > 0.0
                                         ? content.description.seconds / static_cast<double>(frames)
                                         : Median(milliseconds) / 1000.0;
    absl::StrAppend(
        &html, Tile(absl::StrFormat("%.2f s", seconds_per_frame), "a frame"),
        Tile(DescribeDuration(content.description.seconds), "in all"),
        Tile(absl::StrCat(content.lines.back().model_size), "points in the model at the end"),
        Tile(absl::StrFormat("%.1f %%", 100.0 * Median(shares)), "of a frame moves, median"));
  }
  return absl::StrCat(html, "</section>\n");
}

std::string Pictures(const ReportContent& content) {
  std::string html = "<h2>What moves</h2>\n";
  if (!content.pictures_note.empty()) {
    absl::StrAppend(&html, "<p class=\"note\">", EscapeHtml(content.pictures_note), "</p>\n");
  }
  absl::StrAppend(&html, "<section class=\"pictures\">\n");
  for (const ReportPicture& picture : content.pictures) {
    const std::string caption = EscapeHtml(picture.caption);
    absl::StrAppend(&html, "<figure><img alt=\"overlay of ", caption,
                    "\" src=\"data:image/jpeg;base64,", absl::Base64Escape(picture.jpeg),
                    "\"><figcaption>", caption, "</figcaption></figure>\n");
  }
  return absl::StrCat(html, "</section>\n");
}

std::string Charts(const ReportContent& content) {
  if (content.lines.empty()) {
    return "<p class=\"note\">No frame was answered.</p>\n";
  }
  const std::vector<Chart> charts =
      MakeCharts(content.lines, content.evaluation, content.max_chart_points);
  std::string html =
      "<h2>Over the drive</h2>\n<p class=\"note\">Drag along a chart to zoom all of them, "
      "double-click to see the whole drive again.</p>\n<noscript><p class=\"note\">The charts need "
      "JavaScript.</p></noscript>\n<section class=\"charts\">\n";
  nlohmann::ordered_json data = nlohmann::ordered_json::array();
  for (const Chart& chart : charts) {
    absl::StrAppend(&html, "<div class=\"card\"><h3>", EscapeHtml(chart.title), "</h3><p>",
                    EscapeHtml(chart.caption), "</p><div class=\"plot\" id=\"plot-", chart.id,
                    "\"></div><div class=\"key\" id=\"key-", chart.id, "\"></div></div>\n");
    data.push_back(ToJson(chart));
  }
  // "</" would end the script element.
  const std::string json = absl::StrReplaceAll(data.dump(), {{"</", "<\\/"}});
  return absl::StrCat(html, "</section>\n<script type=\"application/json\" id=\"charts\">", json,
                      "</script>\n");
}

std::string MotionModels(absl::Span<const FrameLine> lines) {
  std::map<std::string, int64_t> counts;
  for (const FrameLine& line : lines) {
    ++counts[line.motion_model];
  }
  std::string html =
      "<h2>Motion of the camera</h2>\n<table><tr><th>motion model chosen</th><th "
      "class=\"number\">frames</th><th class=\"number\">share</th></tr>\n";
  for (const auto& [model, count] : counts) {
    absl::StrAppend(&html, "<tr><td>", EscapeHtml(model), "</td><td class=\"number\">", count,
                    "</td><td class=\"number\">",
                    absl::StrFormat("%.1f %%", 100.0 * static_cast<double>(count) /
                                                   static_cast<double>(lines.size())),
                    "</td></tr>\n");
  }
  return absl::StrCat(html, "</table>\n");
}

// Reasons often carry a number; frames are told by reason, in the order in which each came first.
std::string NotLearnt(absl::Span<const FrameLine> lines) {
  std::vector<std::string> reasons;
  std::map<std::string, std::vector<int64_t>> indices;
  for (const FrameLine& line : lines) {
    if (line.outcome == Outcome::kLearnt) continue;
    const std::string reason =
        absl::StrCat(line.outcome == Outcome::kFailed ? "failed: " : "", line.reason);
    if (indices[reason].empty()) {
      reasons.push_back(reason);
    }
    indices[reason].push_back(line.index);
  }
  std::string html = "<h2>Frames that were not learnt from</h2>\n";
  if (reasons.empty()) {
    return absl::StrCat(html, "<p class=\"note\">None: every frame was learnt from.</p>\n");
  }
  absl::StrAppend(&html,
                  "<div class=\"scroll\"><table><tr><th>reason</th><th class=\"number\">count</th>"
                  "<th>frames</th></tr>\n");
  for (const std::string& reason : reasons) {
    const std::vector<int64_t>& frames = indices[reason];
    absl::StrAppend(&html, "<tr><td>", EscapeHtml(reason), "</td><td class=\"number\">",
                    frames.size(), "</td><td>", DescribeRanges(frames), "</td></tr>\n");
  }
  return absl::StrCat(html, "</table></div>\n");
}

std::string EvaluationTable(const Evaluation& evaluation) {
  const auto number = [](const std::optional<double>& value) {
    return value ? absl::StrFormat("%.4f", *value) : std::string("none");
  };
  std::string html = absl::StrCat(
      "<h2>Evaluation</h2>\n<p>Pooled AUC <b>", number(evaluation.pooled_auc),
      "</b>, mean over frames <b>", number(evaluation.mean_auc), "</b>, on ",
      evaluation.frames.size(), " frames (", EscapeHtml(evaluation.pixels), " pixels) against ",
      EscapeHtml(evaluation.truth), "; left out: ", evaluation.frames_of_prior, " of the prior, ",
      evaluation.frames_without_mask, " without a mask, ", evaluation.frames_without_map,
      " without a map.</p>\n");
  absl::StrAppend(&html,
                  "<details><summary>Frame by frame</summary><div class=\"scroll\"><table><tr><th "
                  "class=\"number\">frame</th><th class=\"number\">dynamic pixels</th><th "
                  "class=\"number\">static pixels</th><th class=\"number\">AUC</th></tr>\n");
  for (const FrameScores& frame : evaluation.frames) {
    absl::StrAppend(&html, "<tr><td class=\"number\">", frame.index, "</td><td class=\"number\">",
                    frame.dynamic_pixels, "</td><td class=\"number\">", frame.static_pixels,
                    "</td><td class=\"number\">", number(frame.auc), "</td></tr>\n");
  }
  return absl::StrCat(html, "</table></div></details>\n");
}

std::string Flags(const RunDescription& description) {
  std::string html = "<h2>Flags</h2>\n<details><summary>All flags of the run</summary><table>\n";
  for (const auto& [name, value] : description.flags) {
    absl::StrAppend(&html, "<tr><th>--", EscapeHtml(name), "</th><td>", EscapeHtml(value),
                    "</td></tr>\n");
  }
  return absl::StrCat(html, "</table></details>\n");
}

}  // namespace

std::string EscapeHtml(absl::string_view text) {
  return absl::StrReplaceAll(
      text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}});
}

std::string DescribeRanges(absl::Span<const int64_t> indices) {
  std::vector<std::string> ranges;
  for (size_t begin = 0; begin < indices.size();) {
    size_t end = begin + 1;
    while (end < indices.size() && indices[end] == indices[end - 1] + 1) ++end;
    ranges.push_back(end - begin == 1 ? absl::StrCat(indices[begin])
                                      : absl::StrCat(indices[begin], "-", indices[end - 1]));
    begin = end;
  }
  return absl::StrJoin(ranges, ", ");
}

std::string MakeReportPage(const ReportContent& content) {
  const RunDescription& description = content.description;
  std::string html = absl::StrCat(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
      "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Egosieve: ",
      EscapeHtml(Title(description)), "</title>\n<style>\n", kDygraphsCss, kPageCss,
      "</style>\n</head>\n<body>\n<main>\n");
  absl::StrAppend(&html, Header(description), Tiles(content));
  if (!content.pictures.empty() || !content.pictures_note.empty()) {
    absl::StrAppend(&html, Pictures(content));
  }
  absl::StrAppend(&html, Charts(content));
  if (content.evaluation) {
    absl::StrAppend(&html, EvaluationTable(*content.evaluation));
  }
  if (!content.lines.empty()) {
    absl::StrAppend(&html, NotLearnt(content.lines), MotionModels(content.lines));
  }
  absl::StrAppend(&html, Flags(description), "</main>\n");
  if (!content.lines.empty()) {
    absl::StrAppend(&html, "<script>", kDygraphsJs, "</script>\n<script>", kPageJs, "</script>\n");
  }
  return absl::StrCat(html, "</body>\n</html>\n");
}

}  // namespace egosieve::tools
