// The report of a drive: one HTML page that needs no other file.
//
// Charts are drawn by dygraphs (https://dygraphs.com, MIT licence), which is embedded in the page.
// Without JavaScript, the figures, pictures and tables remain.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "tools/report/evaluation_file.h"
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
  std::optional<EvaluationFile> evaluation;
  std::string tracks;  // the text of tracks.csv; empty if there is none
  std::string video;   // the overlay video's path from the page; empty if there is none
  std::vector<ReportPicture> pictures;
  std::vector<std::string> picture_notes;  // their contents, and missing pictures with reasons
  int64_t max_chart_points = 600;          // longer drives are averaged
};

std::string MakeReportPage(const ReportContent& content);

// "0-3, 7, 9-12" for increasing indices. If there are more than `max_ranges` ranges, the longest
// ones and the number of other indices: "0-3, 9-12, and 1 more".
std::string DescribeRanges(absl::Span<const int64_t> indices, size_t max_ranges = SIZE_MAX);

}  // namespace egosieve::tools
