// A grid of settings of `segment`: every combination of the values given for each flag.
//
//   "budget=1000,1500;frame_gap=1,2"  ->  --budget=1000 --frame_gap=1,  --budget=1000
//   --frame_gap=2,
//                                         --budget=1500 --frame_gap=1,  --budget=1500 --frame_gap=2
#ifndef EGOSIEVE_TOOLS_TUNE_DEFAULTS_SETTING_GRID_H_
#define EGOSIEVE_TOOLS_TUNE_DEFAULTS_SETTING_GRID_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "tools/suite/suite_table.h"

namespace egosieve::tools {

struct Setting {
  std::string name;                // budget=1000,frame_gap=1; "as it is" without flags
  std::string folder;              // the same, fit for a folder's name
  std::vector<std::string> flags;  // --budget=1000 --frame_gap=1
};

// The settings in the order of the grid, the defaults as they are first. InvalidArgument where an
// entry is not FLAG=VALUE,VALUE or there are more than `most` settings.
absl::StatusOr<std::vector<Setting>> ParseGrid(absl::string_view grid, int most);

// How good a setting is: every group of sequences weighs the same, whatever its number of
// sequences, so that no data set decides alone.
struct SettingScore {
  std::string name;
  std::optional<double> auc;        // mean over groups of the mean over sequences
  std::optional<double> iou;        // likewise, best one threshold of each sequence
  std::optional<double> least_auc;  // of the worst sequence
  int failed = 0;
};

SettingScore ScoreOfSetting(const std::string& name, const std::string& profile,
                            const SuiteSummary& summary);

// Best AUC first; settings that failed anywhere behind all others. Those within `noise` of the best
// are as good: among them the defaults stay, or else the one that comes first in the grid.
std::string RankTable(std::vector<SettingScore> scores, double noise);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_TUNE_DEFAULTS_SETTING_GRID_H_
