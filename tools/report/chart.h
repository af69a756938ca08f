// The report's charts, as data: one line a series over the frame's index.
//
// A drive of n frames has more points than a screen has columns. From `max_points` on, k = ceil(n /
// max_points) frames in a row become one point: the mean of what is finite among them, at the index
// of the first.
#ifndef EGOSIEVE_TOOLS_REPORT_CHART_H_
#define EGOSIEVE_TOOLS_REPORT_CHART_H_

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "tools/evaluate/evaluation.h"
#include "tools/run_folder/frame_line.h"

namespace egosieve::tools {

struct Chart {
  std::string id;  // letters only
  std::string title;
  std::string caption;  // what it shows, with units; one sentence or two
  std::string unit;     // of the vertical axis
  bool stacked = false;
  bool from_zero = true;  // the vertical axis starts at 0 and ends where 98 % of the points lie

  std::vector<std::string> series = {};
  std::vector<double> x = {};                    // frame indices
  std::vector<std::vector<double>> values = {};  // a row a series; NaN: none
};

// Charts without a finite point are left out. At least one frame.
std::vector<Chart> MakeCharts(absl::Span<const FrameLine> lines,
                              const std::optional<Evaluation>& evaluation, int64_t max_points);

// What the page's script reads.
nlohmann::ordered_json ToJson(const Chart& chart);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_REPORT_CHART_H_
