// A grid of settings of `segment`: every combination of the values given for each flag.
//
//   "budget=1000,1500;frame_gap=1,2"  ->
//       --budget=1000 --frame_gap=1,  --budget=1000 --frame_gap=2,
//       --budget=1500 --frame_gap=1,  --budget=1500 --frame_gap=2
#ifndef EGOSIEVE_TOOLS_LAB_TUNE_DEFAULTS_SETTING_GRID_H_
#define EGOSIEVE_TOOLS_LAB_TUNE_DEFAULTS_SETTING_GRID_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "tools/suite/suite_table.h"

namespace egosieve::tools {

struct Setting {
  std::string name;                // budget=1000,frame_gap=1; "as it is" without flags
  std::string folder;              // the same, usable as a folder's name
  std::vector<std::string> flags;  // --budget=1000 --frame_gap=1
};

// The settings in the order of the grid; the unchanged defaults come first. InvalidArgument if an
// entry is not FLAG=VALUE,VALUE or there are more than `most` settings.
absl::StatusOr<std::vector<Setting>> ParseGrid(absl::string_view grid, int most);

// The score of a setting: every group of sequences has the same weight, whatever its number of
// sequences, so that no data set dominates.
struct SettingScore {
  std::string name;
  std::optional<double> auc;        // mean over groups of the mean over sequences
  std::optional<double> iou;        // likewise, at the best single threshold of each sequence
  std::optional<double> least_auc;  // of the worst sequence
  int failed = 0;
};

SettingScore ScoreOfSetting(const std::string& name, const std::string& profile,
                            const SuiteSummary& summary);

// Best AUC first; settings that failed anywhere come last. Settings within `noise` of the best
// count as equal: among them the defaults are preferred, else the first in the grid.
std::string RankTable(std::vector<SettingScore> scores, double noise);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_TUNE_DEFAULTS_SETTING_GRID_H_
