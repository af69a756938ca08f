#include "tools/report/page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "tools/cli/progress.h"
#include "tools/report/chart.h"
#include "tools/report/embedded_files.h"
#include "tools/report/html.h"
#include "tools/report/timeline.h"
#include "tools/run_folder/baselines.h"
#include "tools/run_folder/doubtful_frames.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::tools {
namespace {

using Outcome = FrameLine::Outcome;

// Largest number of ranges shown per reason; the log has all frames.
constexpr size_t kShownRanges = 20;

double MedianOrZero(const std::vector<double>& values) {
  return values.empty() ? 0.0 : vision::Median(values);
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

// The input's last two path components: "car-shadow/frames" is more specific than "frames".
std::string Title(const RunDescription& description) {
  const std::filesystem::path path(description.input.path);
  return (path.parent_path().filename() / path.filename()).string();
}

// Describes maps that were made on another device than the run's.
std::string OtherDevices(absl::Span<const FrameLine> lines) {
  std::map<std::string, int64_t> counts;
  for (const FrameLine& line : lines) {
    if (!line.map_device.empty()) ++counts[line.map_device];
  }
  std::string html;
  for (const auto& [device, count] : counts) {
    absl::StrAppend(&html, "<p>maps made on ", EscapeHtml(device), ": ", count, "</p>\n");
  }
  return html;
}

std::string FarApart(const ReportContent& content) {
  Baselines baselines(content.description);
  for (const FrameLine& line : content.lines) baselines.Add(line);
  const std::string text = baselines.Describe();
  return text.empty() ? "" : absl::StrCat("<p><b>", EscapeHtml(text), "</b></p>\n");
}

std::string Header(const ReportContent& content) {
  const RunDescription& description = content.description;
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
  absl::StrAppend(&html, "</p>\n", OtherDevices(content.lines), FarApart(content));
  if (!description.ended_message.empty()) {
    absl::StrAppend(&html, "<p><b>", EscapeHtml(description.ended_message), "</b></p>\n");
  }
  DoubtfulFrames doubtful;
  for (const FrameLine& line : content.lines) doubtful.Add(line);
  if (doubtful.count() > 0) {
    absl::StrAppend(&html, "<p class=\"warning\">", EscapeHtml(doubtful.Sentence()), "</p>\n");
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
    if (line.model_size > 0 && line.has_map()) shares.push_back(line.dynamic_share);
  }
  const int64_t frames = static_cast<int64_t>(content.lines.size());
  std::string html = "<section class=\"tiles\">\n";
  absl::StrAppend(&html, Tile(absl::StrCat(frames - failed), "frames answered"),
                  Tile(absl::StrCat(learnt), "learnt from"), Tile(absl::StrCat(failed), "failed"));
  if (content.evaluation && std::isfinite(content.evaluation->pooled_auc)) {
    absl::StrAppend(&html, Tile(absl::StrFormat("%.3f", content.evaluation->pooled_auc),
                                "pooled AUC against the truth"));
  }
  if (frames > 0) {
    // Stages overlap, so take the clock's time; while the run has not ended, the sum of the stages.
    const double seconds_per_frame = content.description.seconds > 0.0
                                         ? content.description.seconds / static_cast<double>(frames)
                                         : MedianOrZero(milliseconds) / 1000.0;
    absl::StrAppend(
        &html, Tile(absl::StrFormat("%.2f s", seconds_per_frame), "per frame"),
        Tile(DescribeDuration(content.description.seconds), "in all"),
        Tile(absl::StrCat(content.lines.back().model_size), "points in the model at the end"));
  }
  if (!shares.empty()) {
    absl::StrAppend(&html, Tile(absl::StrFormat("%.1f %%", 100.0 * MedianOrZero(shares)),
                                "of a frame moves, median"));
  }
  return absl::StrCat(html, "</section>\n");
}

// A click enlarges a picture; arrow keys move between pictures (page.js).
std::string Pictures(const ReportContent& content) {
  std::string html = "<h2>What moves</h2>\n";
  const std::string timeline = MoverTimeline(content.tracks, content.lines);
  if (!timeline.empty()) {
    absl::StrAppend(&html, timeline,
                    "<p class=\"note\">When each mover was there, by its number. Grey: unreliable "
                    "frames.</p>\n");
  }
  if (!content.video.empty()) {
    absl::StrAppend(&html, "<p><a href=\"", EscapeHtml(content.video), "\">",
                    EscapeHtml(content.video), "</a></p>\n");
  }
  for (const std::string& note : content.picture_notes) {
    absl::StrAppend(&html, "<p class=\"note\">", EscapeHtml(note), "</p>\n");
  }
  absl::StrAppend(&html, "<section class=\"pictures\">\n");
  for (const ReportPicture& picture : content.pictures) {
    const std::string caption = EscapeHtml(picture.caption);
    absl::StrAppend(&html, "<figure", picture.is_unreliable ? " class=\"unreliable\"" : "",
                    "><img tabindex=\"0\" alt=\"overlay of ", caption,
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
      "<h2>Over the drive</h2>\n<p class=\"note\">Over the frames' numbers in the input. "
      "Drag along a chart to zoom all of them, double-click to see the whole drive "
      "again.</p>\n<noscript><p class=\"note\">The charts need "
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

// Milliseconds per stage over the frames that have the stage: typical and bad frames.
std::string StageTable(absl::Span<const FrameLine> lines) {
  std::vector<std::string> stages;
  std::map<std::string, std::vector<double>> times;
  for (const FrameLine& line : lines) {
    for (const auto& [stage, milliseconds] : line.milliseconds) {
      if (times.find(stage) == times.end()) stages.push_back(stage);
      times[stage].push_back(milliseconds);
    }
  }
  std::string html =
      "<h2>Time by stage</h2>\n<table><tr><th>stage</th><th class=\"number\">median, ms</th><th "
      "class=\"number\">95 % below, ms</th><th class=\"number\">slowest, ms</th><th "
      "class=\"number\">share of all</th></tr>\n";
  double total = 0.0;
  for (const auto& [stage, values] : times) {
    total += std::accumulate(values.begin(), values.end(), 0.0);
  }
  for (const std::string& stage : stages) {
    std::vector<double>& values = times[stage];
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    absl::StrAppend(&html, "<tr><td>", EscapeHtml(stage), "</td>");
    for (const double share : {0.5, 0.95, 1.0}) {
      absl::StrAppendFormat(&html, "<td class=\"number\">%.1f</td>",
                            vision::QuantileInPlace(values, share));
    }
    absl::StrAppendFormat(&html, "<td class=\"number\">%.1f %%</td></tr>\n",
                          total > 0.0 ? 100.0 * sum / total : 0.0);
  }
  return absl::StrCat(html, "</table>\n");
}

// Frames by reason, ignoring numbers: the most frequent first, with the text of its first frame.
std::string NotLearnt(absl::Span<const FrameLine> lines) {
  struct Group {
    std::string reason;
    std::vector<int64_t> frames;
  };
  std::map<std::string, Group> groups;
  for (const FrameLine& line : lines) {
    if (line.outcome == Outcome::kLearnt) continue;
    const std::string reason =
        absl::StrCat(line.outcome == Outcome::kFailed ? "failed: " : "", line.reason);
    Group& group = groups[WithoutNumbers(reason)];
    if (group.frames.empty()) group.reason = reason;
    group.frames.push_back(line.index);
  }
  std::string html = "<h2>Frames that were not learnt from</h2>\n";
  if (groups.empty()) {
    return absl::StrCat(html, "<p class=\"note\">None: every frame was learnt from.</p>\n");
  }
  std::vector<const Group*> sorted;
  for (const auto& [key, group] : groups) sorted.push_back(&group);
  std::stable_sort(sorted.begin(), sorted.end(), [](const Group* a, const Group* b) {
    return a->frames.size() > b->frames.size();
  });
  absl::StrAppend(&html,
                  "<p class=\"note\">Reasons that differ in their numbers alone are one; the first "
                  "frame's numbers are shown.</p>\n<div class=\"scroll\"><table><tr><th>reason</th>"
                  "<th class=\"number\">count</th><th>frames</th></tr>\n");
  for (const Group* group : sorted) {
    absl::StrAppend(&html, "<tr><td>", EscapeHtml(group->reason), "</td><td class=\"number\">",
                    group->frames.size(), "</td><td>", DescribeRanges(group->frames, kShownRanges),
                    "</td></tr>\n");
  }
  return absl::StrCat(html, "</table></div>\n");
}

std::string EvaluationTable(const EvaluationFile& evaluation) {
  const auto number = [](double value) {
    return std::isfinite(value) ? absl::StrFormat("%.4f", value) : std::string("none");
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
  for (const EvaluatedFrame& frame : evaluation.frames) {
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

std::string DescribeRanges(absl::Span<const int64_t> indices, size_t max_ranges) {
  struct Range {
    int64_t first, last;
  };
  std::vector<Range> ranges;
  for (const int64_t index : indices) {
    if (!ranges.empty() && index == ranges.back().last + 1) {
      ranges.back().last = index;
    } else {
      ranges.push_back({index, index});
    }
  }
  std::vector<Range> shown = ranges;
  if (ranges.size() > max_ranges) {
    std::stable_sort(shown.begin(), shown.end(), [](const Range& a, const Range& b) {
      return a.last - a.first > b.last - b.first;
    });
    shown.resize(max_ranges);
    std::sort(shown.begin(), shown.end(),
              [](const Range& a, const Range& b) { return a.first < b.first; });
  }
  std::vector<std::string> texts;
  int64_t left = static_cast<int64_t>(indices.size());
  for (const Range& range : shown) {
    left -= range.last - range.first + 1;
    texts.push_back(range.first == range.last ? absl::StrCat(range.first)
                                              : absl::StrCat(range.first, "-", range.last));
  }
  if (left > 0) texts.push_back(absl::StrCat("and ", left, " more"));
  return absl::StrJoin(texts, ", ");
}

std::string MakeReportPage(const ReportContent& content) {
  const RunDescription& description = content.description;
  std::string html = absl::StrCat(PageHead(absl::StrCat("Egosieve: ", Title(description)),
                                           absl::StrCat(kDygraphsCss, PageStyle())),
                                  "<main>\n");
  absl::StrAppend(&html, Header(content), Tiles(content));
  if (!content.pictures.empty() || !content.picture_notes.empty() || !content.tracks.empty()) {
    absl::StrAppend(&html, Pictures(content));
  }
  if (content.evaluation) {
    absl::StrAppend(&html, EvaluationTable(*content.evaluation));
  }
  if (!content.lines.empty()) absl::StrAppend(&html, NotLearnt(content.lines));
  absl::StrAppend(&html, Charts(content));
  if (!content.lines.empty()) {
    absl::StrAppend(&html, StageTable(content.lines), MotionModels(content.lines));
  }
  absl::StrAppend(&html, Flags(description), "</main>\n");
  if (!content.lines.empty()) {
    absl::StrAppend(&html, "<script>", kDygraphsJs, "</script>\n<script>", kPageJs, "</script>\n");
  }
  return absl::StrCat(html, "</body>\n</html>\n");
}

}  // namespace egosieve::tools
