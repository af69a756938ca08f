// The work of `egosieve lab tune_defaults`: runs every setting on all sequences of several suites.
#ifndef EGOSIEVE_TOOLS_LAB_TUNE_DEFAULTS_TUNE_DEFAULTS_RUN_H_
#define EGOSIEVE_TOOLS_LAB_TUNE_DEFAULTS_TUNE_DEFAULTS_RUN_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/cli/progress.h"
#include "tools/lab/tune_defaults/setting_grid.h"
#include "tools/suite/suite_run.h"

namespace egosieve::tools {

struct TuneDefaultsOptions {
  std::vector<std::string> suites;  // folders of sequences
  std::string grid;                 // of ParseGrid
  std::string profile = "default";  // that the settings change
  SuiteOptions suite;               // its `out` holds a folder per setting
};

// The scores of the settings, in the order of the grid. A suite without groups is one group.
absl::StatusOr<std::vector<SettingScore>> ScoreSettings(const TuneDefaultsOptions& options,
                                                        const ProgressFlag& progress);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_TUNE_DEFAULTS_TUNE_DEFAULTS_RUN_H_
