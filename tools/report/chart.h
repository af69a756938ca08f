// The report's charts, as data: one line per series over the frame's index.
//
// A long drive has more frames than a screen has columns. If n exceeds `max_points`, k = ceil(n /
// max_points) consecutive frames become one point: the mean of their finite values, at the index of
// the first frame.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "tools/report/evaluation_file.h"
#include "tools/run_folder/frame_line.h"

namespace egosieve::tools {

struct Chart {
  std::string id;  // letters only
  std::string title;
  std::string caption;  // what it shows, with units; one sentence or two
  std::string unit;     // of the vertical axis
  bool stacked = false;
  bool from_zero = true;  // the vertical axis starts at 0 and includes 98 % of the points

  std::vector<std::string> series = {};
  std::vector<double> x = {};                    // frame indices
  std::vector<std::vector<double>> values = {};  // one row per series; NaN: none
};

// Charts without a finite point are left out. Needs at least one frame.
std::vector<Chart> MakeCharts(absl::Span<const FrameLine> lines,
                              const std::optional<EvaluationFile>& evaluation, int64_t max_points);

// The data for the page's script.
nlohmann::ordered_json ToJson(const Chart& chart);

}  // namespace egosieve::tools
