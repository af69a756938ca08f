// The report of a drive: one HTML page that needs no other file.
//
// The page holds its contents as JSON, which page.js lays out; charts are drawn by dygraphs
// (https://dygraphs.com, MIT licence), which is embedded, too.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_description.h"

namespace egosieve::tools {

struct ReportPicture {
  std::string jpeg;  // the file's bytes
  std::string caption;
  bool is_unreliable = false;  // DoubtOf is not empty
};

struct ReportContent {
  RunDescription description;
  std::vector<FrameLine> lines;
  nlohmann::ordered_json evaluation;  // eval.json, which egosieve-eval writes; null: none
  std::string tracks;                 // the text of tracks.csv; empty if there is none
  std::string video;  // the overlay video's path from the page; empty if there is none
  std::vector<ReportPicture> pictures;
  std::vector<std::string> picture_notes;  // their contents, and missing pictures with reasons
  int64_t max_chart_points = 600;          // longer drives are averaged
};

std::string MakeReportPage(const ReportContent& content);

// The charts' data: every number of the frames' lines, by its JSON pointer. {step, index, columns}:
// a long drive has more frames than a screen has columns, so of more than `max_points` frames each
// point is the mean of `step`, at the index of the first; null where none of them has a number.
nlohmann::ordered_json ColumnsOf(absl::Span<const FrameLine> lines, int64_t max_points);

// What the page says of an evaluation. Throws Json::exception, naming the field, if it lacks one.
nlohmann::ordered_json EvaluationSection(const nlohmann::ordered_json& evaluation);

// "0-3, 7, 9-12" for increasing indices. If there are more than `max_ranges` ranges, the longest
// ones and the number of other indices: "0-3, 9-12, and 1 more".
std::string DescribeRanges(absl::Span<const int64_t> indices, size_t max_ranges = SIZE_MAX);

}  // namespace egosieve::tools
