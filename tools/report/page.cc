#include "tools/report/page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "tools/cli/progress.h"
#include "tools/render/overlay.h"
#include "tools/report/embedded_files.h"
#include "tools/run_folder/baselines.h"
#include "tools/run_folder/doubtful_frames.h"
#include "tools/run_folder/mover_tracks.h"
#include "tools/run_folder/verdict.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;
using Outcome = FrameLine::Outcome;
using Range = std::pair<int64_t, int64_t>;  // first and last

// Largest number of ranges shown per reason; the log has all frames.
constexpr size_t kShownRanges = 20;
constexpr size_t kShownMovers = 40;

double MedianOrZero(const std::vector<double>& values) {
  return values.empty() ? 0.0 : vision::Median(values);
}

double TotalMilliseconds(const FrameLine& line) {
  double total = 0.0;
  for (const auto& [stage, milliseconds] : line.milliseconds) total += milliseconds;
  return total;
}

// Of increasing indices.
std::vector<Range> RangesOf(absl::Span<const int64_t> indices) {
  std::vector<Range> ranges;
  for (const int64_t index : indices) {
    if (ranges.empty() || index != ranges.back().second + 1) ranges.emplace_back(index, index);
    ranges.back().second = index;
  }
  return ranges;
}

// The input's last two path components: "car-shadow/frames" is more specific than "frames".
std::string Title(const RunDescription& description) {
  const std::filesystem::path path(description.input.path);
  return (path.parent_path().filename() / path.filename()).string();
}

// Lines below the title: [text, class of the style sheet].
Json About(const ReportContent& content) {
  const RunDescription& run = content.description;
  Json about = Json::array();
  const auto say = [&](const std::string& text, const char* kind = "") {
    if (!text.empty()) about.push_back(Json::array({text, kind}));
  };
  say(absl::StrCat(run.input.path, " (", run.grid.width, " \u00d7 ", run.grid.height, ", ",
                   run.input.kind, ")"));
  say(absl::StrCat("egosieve ", run.version, " on ", run.device, "; started ", run.started_utc,
                   run.finished_utc.empty() ? "" : ", ended ", run.finished_utc));
  std::map<std::string, int64_t> other_devices;
  Baselines baselines(run);
  for (const FrameLine& line : content.lines) {
    if (!line.map_device.empty()) ++other_devices[line.map_device];
    baselines.Add(line);
  }
  for (const auto& [device, count] : other_devices) {
    say(absl::StrCat("maps made on ", device, ": ", count));
  }
  say(baselines.Describe(), "strong");
  say(run.ended_message, "strong");
  return about;
}

// What `egosieve run` ends with: [word, text, class of the style sheet].
Json Verdict(const ReportContent& content) {
  if (content.lines.empty()) return Json::array();
  const std::string doubt = DoubtLine(content.lines);
  Json verdict = Json::array();
  if (!content.tracks.empty()) {
    verdict.push_back({"Moved", MoversLine(content.tracks, content.lines), ""});
  }
  verdict.push_back({"Sure", CertaintyLine(content.tracks, content.lines), ""});
  verdict.push_back({"Doubtful", doubt, doubt == DoubtLine({}) ? "" : "warning"});
  return verdict;
}

// [figure, meaning]
Json Tiles(const ReportContent& content) {
  int64_t learnt = 0, failed = 0;
  std::vector<double> milliseconds, shares;
  for (const FrameLine& line : content.lines) {
    learnt += line.outcome == Outcome::kLearnt;
    failed += line.outcome == Outcome::kFailed;
    milliseconds.push_back(TotalMilliseconds(line));
    if (line.model_size > 0 && line.has_map()) shares.push_back(line.dynamic_share);
  }
  const int64_t frames = static_cast<int64_t>(content.lines.size());
  Json tiles = Json::array();
  const auto add = [&](const std::string& figure, const char* meaning) {
    tiles.push_back(Json::array({figure, meaning}));
  };
  add(absl::StrCat(frames - failed), "frames answered");
  add(absl::StrCat(learnt), "learnt from");
  add(absl::StrCat(failed), "failed");
  if (!content.evaluation.is_null() && content.evaluation["pooled_auc"].is_number()) {
    add(absl::StrFormat("%.3f", content.evaluation["pooled_auc"].get<double>()),
        "pooled AUC against the truth");
  }
  if (frames > 0) {
    // Stages overlap, so take the clock's time; while the run has not ended, the sum of the stages.
    const double seconds_per_frame = content.description.seconds > 0.0
                                         ? content.description.seconds / static_cast<double>(frames)
                                         : MedianOrZero(milliseconds) / 1000.0;
    add(absl::StrFormat("%.2f s", seconds_per_frame), "per frame");
    add(DescribeDuration(content.description.seconds), "in all");
    add(absl::StrCat(content.lines.back().model_size), "points in the model at the end");
  }
  if (!shares.empty()) {
    add(absl::StrFormat("%.1f %%", 100.0 * MedianOrZero(shares)), "of a frame moves, median");
  }
  return tiles;
}

// When each mover was visible: a row per number, the longest visible kShownMovers in the order of
// their first frames. Null without movers.
Json Timeline(const std::string& tracks, const std::vector<FrameLine>& lines) {
  std::vector<MoverTrack> movers = ReadMoverTracks(tracks);
  if (movers.empty() || lines.empty()) return nullptr;
  const size_t left_out = movers.size() - std::min(movers.size(), kShownMovers);
  movers.resize(movers.size() - left_out);
  std::ranges::stable_sort(movers, {},
                           [](const MoverTrack& mover) { return mover.sightings.front().frame; });
  Json rows = Json::array();
  for (const MoverTrack& mover : movers) {
    std::vector<int64_t> frames;
    for (const Sighting& sighting : mover.sightings) frames.push_back(sighting.frame);
    const cv::Vec3b colour = MoverColour(mover.number);
    rows.push_back({{"number", mover.number},
                    {"colour", absl::StrFormat("#%02x%02x%02x", colour[2], colour[1], colour[0])},
                    {"stays", RangesOf(frames)}});
  }
  std::vector<int64_t> doubtful;
  for (const FrameLine& line : lines) {
    if (!DoubtOf(line).empty()) doubtful.push_back(line.index);
  }
  std::string note = "When each mover was there, by its number. Amber: unreliable frames.";
  if (left_out > 0) {
    absl::StrAppend(&note, " ", left_out, " movers that were there shorter are in tracks.csv.");
  }
  return {{"first", lines.front().index},
          {"last", lines.back().index},
          {"doubtful", RangesOf(doubtful)},
          {"rows", rows},
          {"note", note}};
}

// numbers: the columns that hold numbers.
Json Table(std::vector<std::string> head, std::vector<int> numbers, Json rows) {
  return {{"head", std::move(head)}, {"numbers", std::move(numbers)}, {"rows", std::move(rows)}};
}

// Unreliable frames that follow each other.
struct Stretch {
  const FrameLine* first = nullptr;
  const FrameLine* last = nullptr;
  int64_t frames = 0;
  ReasonKinds reasons;
};

// The longest kShownRanges stretches, in their order. Null where every frame is reliable.
Json Doubtful(absl::Span<const FrameLine> lines) {
  std::vector<Stretch> stretches;
  bool is_within = false;
  for (const FrameLine& line : lines) {
    const std::string doubt = DoubtOf(line);
    if (!doubt.empty()) {
      if (!is_within) stretches.emplace_back().first = &line;
      stretches.back().last = &line;
      ++stretches.back().frames;
      stretches.back().reasons.Add(doubt, line.index);
    }
    is_within = !doubt.empty();
  }
  if (stretches.empty()) return nullptr;
  const size_t left_out = stretches.size() - std::min(stretches.size(), kShownRanges);
  std::ranges::stable_sort(stretches, std::greater<>(), &Stretch::frames);
  stretches.resize(stretches.size() - left_out);
  std::ranges::sort(stretches, {}, [](const Stretch& stretch) { return stretch.first->index; });
  Json rows = Json::array();
  for (const Stretch& stretch : stretches) {
    rows.push_back(
        {absl::StrFormat("%.1f to %.1f", stretch.first->time_seconds, stretch.last->time_seconds),
         absl::StrCat(stretch.first->index, " to ", stretch.last->index), stretch.frames,
         stretch.reasons.MostFrequentFirst().front().first});
  }
  Json section = {
      {"title", "What is doubtful"},
      {"table", Table({"seconds", "frames", "count", "most often because"}, {2}, rows)}};
  if (left_out > 0) section["notes"] = {absl::StrCat(left_out, " shorter stretches are left out.")};
  return section;
}

Json Pictures(const ReportContent& content) {
  Json pictures = Json::array();
  for (const ReportPicture& picture : content.pictures) {
    pictures.push_back({{"source", "data:image/jpeg;base64," + absl::Base64Escape(picture.jpeg)},
                        {"caption", picture.caption},
                        {"unreliable", picture.is_unreliable}});
  }
  return {{"title", "What moves"},
          {"timeline", Timeline(content.tracks, content.lines)},
          {"portrait", content.description.grid.height > content.description.grid.width},
          {"video", content.video},
          {"notes", content.picture_notes},
          {"pictures", pictures}};
}

// Every number of the frames, which have an index, by its JSON pointer: {step, index, columns}. If
// there are more than max_points frames, the means of each `step` of them; null where none of them
// has a finite number. frame: gives the frame's JSON by its place.
template <typename Frame>
Json Thinned(size_t frames, int64_t max_points, const Frame& frame) {
  const size_t step = (frames + max_points - 1) / max_points;
  struct Column {
    explicit Column(size_t points) : sums(points), counts(points) {}
    std::vector<double> sums;
    std::vector<int64_t> counts;
  };
  std::map<std::string, Column> columns;
  std::vector<std::string> names;  // in the order of the frames' lines
  Json index = Json::array(), means = Json::object();
  for (size_t i = 0; i < frames; ++i) {
    const Json json = frame(i);
    if (i % step == 0) index.push_back(json["index"]);
    const Json numbers = json.flatten();
    for (const auto& [name, value] : numbers.items()) {
      if (!value.is_number() || !std::isfinite(value.template get<double>())) continue;
      const auto [column, is_new] = columns.try_emplace(name, (frames + step - 1) / step);
      if (is_new) names.push_back(name);
      column->second.sums[i / step] += value.template get<double>();
      ++column->second.counts[i / step];
    }
  }
  for (const std::string& name : names) {
    const auto& [sums, counts] = columns.at(name);
    for (size_t k = 0; k < sums.size(); ++k) {
      means[name].push_back(counts[k] > 0 ? Json(sums[k] / static_cast<double>(counts[k]))
                                          : Json());
    }
  }
  return {{"step", step}, {"index", index}, {"columns", means}};
}

Json Charts(const ReportContent& content) {
  if (content.lines.empty()) return {{"title", ""}, {"notes", {"No frame was answered."}}};
  Json charts = {{"frames", ColumnsOf(content.lines, content.max_chart_points)}};
  if (!content.evaluation.is_null()) {
    const Json& scored = content.evaluation["frames"];
    charts["scores"] =
        Thinned(scored.size(), content.max_chart_points, [&](size_t i) { return scored[i]; });
  }
  return {{"title", "Over the drive"},
          {"notes",
           {"Over the frames' numbers in the input. Drag along a chart to zoom all of them, "
            "double-click to see the whole drive again."}},
          {"charts", charts}};
}

Json MotionModels(absl::Span<const FrameLine> lines) {
  std::map<std::string, int64_t> counts;
  for (const FrameLine& line : lines) ++counts[line.motion_model];
  Json rows = Json::array();
  for (const auto& [model, count] : counts) {
    const double share = static_cast<double>(count) / static_cast<double>(lines.size());
    rows.push_back(Json::array({model, count, absl::StrFormat("%.1f %%", 100.0 * share)}));
  }
  return {{"title", "Motion of the camera"},
          {"table", Table({"motion model chosen", "frames", "share"}, {1, 2}, rows)}};
}

// Milliseconds per stage over the frames that have the stage: typical and bad frames.
Json StageTable(absl::Span<const FrameLine> lines) {
  std::vector<std::string> stages;
  std::map<std::string, std::vector<double>> times;
  double total = 0.0;
  for (const FrameLine& line : lines) {
    for (const auto& [stage, milliseconds] : line.milliseconds) {
      if (times.find(stage) == times.end()) stages.push_back(stage);
      times[stage].push_back(milliseconds);
      total += milliseconds;
    }
  }
  Json rows = Json::array();
  for (const std::string& stage : stages) {
    std::vector<double>& values = times[stage];
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    Json row = {stage};
    for (const double share : {0.5, 0.95, 1.0}) {
      row.push_back(absl::StrFormat("%.1f", vision::QuantileInPlace(values, share)));
    }
    row.push_back(absl::StrFormat("%.1f %%", total > 0.0 ? 100.0 * sum / total : 0.0));
    rows.push_back(row);
  }
  return {{"title", "Time by stage"},
          {"table", Table({"stage", "median, ms", "95 % below, ms", "slowest, ms", "share of all"},
                          {1, 2, 3, 4}, rows)}};
}

// Frames by reason, ignoring numbers: the most frequent first, with the text of its first frame.
Json NotLearnt(absl::Span<const FrameLine> lines) {
  ReasonKinds reasons;
  for (const FrameLine& line : lines) {
    if (line.outcome == Outcome::kLearnt) continue;
    reasons.Add(absl::StrCat(line.outcome == Outcome::kFailed ? "failed: " : "", line.reason),
                line.index);
  }
  Json section = {{"title", "Frames that were not learnt from"}};
  Json rows = Json::array();
  for (const auto& [reason, frames] : reasons.MostFrequentFirst()) {
    rows.push_back(Json::array({reason, frames.size(), DescribeRanges(frames, kShownRanges)}));
  }
  if (rows.empty()) {
    section["notes"] = {"None: every frame was learnt from."};
    return section;
  }
  section["notes"] = {
      "Reasons that differ in their numbers alone are one; the first frame's numbers are shown."};
  section["table"] = Table({"reason", "count", "frames"}, {1}, rows);
  return section;
}

Json Flags(const RunDescription& description) {
  Json rows = Json::array();
  for (const auto& [name, value] : description.flags) {
    rows.push_back(Json::array({"--" + name, value}));
  }
  return {{"title", "Flags"},
          {"summary", "All flags of the run"},
          {"table", Table({"flag", "value"}, {}, rows)}};
}

}  // namespace

Json ColumnsOf(absl::Span<const FrameLine> lines, int64_t max_points) {
  return Thinned(lines.size(), max_points, [&](size_t i) {
    const FrameLine& line = lines[i];
    Json json = ToJson(line);
    const bool is_learnt = line.outcome == Outcome::kLearnt;
    json["outcome"] = {{"learnt from", is_learnt ? 1 : 0},
                       {"not learnt from", line.outcome == Outcome::kAnswered ? 1 : 0},
                       {"failed", line.outcome == Outcome::kFailed ? 1 : 0}};
    if (line.model_size == 0 || !line.has_map()) json["dynamic_share"] = nullptr;
    if (!is_learnt || line.log_likelihood_per_point == 0.0) {
      json["log_likelihood_per_point"] = nullptr;
    }
    return json;
  });
}

Json EvaluationSection(const Json& evaluation) {
  const auto number = [](const Json& value) {
    return value.is_null() ? "none" : absl::StrFormat("%.4f", value.get<double>());
  };
  const auto count = [&](const char* field) { return evaluation.at(field).get<int64_t>(); };
  Json rows = Json::array();
  for (const Json& frame : evaluation.at("frames")) {
    rows.push_back(
        Json::array({frame.at("index").get<int64_t>(), frame.at("dynamic_pixels").get<int64_t>(),
                     frame.at("static_pixels").get<int64_t>(), number(frame.at("auc"))}));
  }
  const std::string figures = absl::StrCat(
      "Pooled AUC ", number(evaluation.at("pooled_auc")), ", mean over frames ",
      number(evaluation.at("mean_auc")), ", on ", rows.size(), " frames (",
      evaluation.at("pixels").get<std::string>(), " pixels) against ",
      evaluation.at("truth").get<std::string>(), "; left out: ", count("frames_of_prior"),
      " of the prior, ", count("frames_without_mask"), " without a mask, ",
      count("frames_without_map"), " without a map.");
  return {
      {"title", "Evaluation"},
      {"notes", {figures}},
      {"summary", "Frame by frame"},
      {"table", Table({"frame", "dynamic pixels", "static pixels", "AUC"}, {0, 1, 2, 3}, rows)}};
}

std::string DescribeRanges(absl::Span<const int64_t> indices, size_t max_ranges) {
  std::vector<Range> shown = RangesOf(indices);
  if (shown.size() > max_ranges) {
    std::ranges::stable_sort(shown, std::greater<>(),
                             [](const Range& range) { return range.second - range.first; });
    shown.resize(max_ranges);
    std::ranges::sort(shown);
  }
  std::vector<std::string> texts;
  int64_t left = static_cast<int64_t>(indices.size());
  for (const auto& [first, last] : shown) {
    left -= last - first + 1;
    texts.push_back(first == last ? absl::StrCat(first) : absl::StrCat(first, "-", last));
  }
  if (left > 0) texts.push_back(absl::StrCat("and ", left, " more"));
  return absl::StrJoin(texts, ", ");
}

std::string MakeReportPage(const ReportContent& content) {
  const RunDescription& run = content.description;
  Json sections = Json::array();
  if (Json doubtful = Doubtful(content.lines); !doubtful.is_null()) sections.push_back(doubtful);
  if (!content.pictures.empty() || !content.picture_notes.empty() || !content.tracks.empty()) {
    sections.push_back(Pictures(content));
  }
  if (!content.evaluation.is_null()) sections.push_back(EvaluationSection(content.evaluation));
  if (!content.lines.empty()) sections.push_back(NotLearnt(content.lines));
  sections.push_back(Charts(content));
  if (!content.lines.empty()) {
    sections.push_back(StageTable(content.lines));
    sections.push_back(MotionModels(content.lines));
  }
  sections.push_back(Flags(run));
  const Json report = {{"title", Title(run)},         {"ended", run.ended},
                       {"verdict", Verdict(content)}, {"about", About(content)},
                       {"tiles", Tiles(content)},     {"sections", sections}};
  // Names of files may hold bytes that are not UTF-8; a "<" could end the script element.
  const std::string json = absl::StrReplaceAll(
      report.dump(-1, ' ', false, Json::error_handler_t::replace), {{"<", "\\u003c"}});
  return absl::StrCat(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>Egosieve</title>\n<style>\n",
      kDygraphsCss, kPageCss,
      "</style>\n</head>\n<body>\n<main><noscript>The report needs JavaScript.</noscript></main>\n"
      "<script type=\"application/json\" id=\"report\">",
      json, "</script>\n<script>", kDygraphsJs, "</script>\n<script>", kPageJs,
      "</script>\n</body>\n</html>\n");
}

}  // namespace egosieve::tools
