#include "tools/lab/tune_defaults/tune_defaults_run.h"

#include <cstdint>
#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/interruption.h"
#include "tools/suite/child_process.h"
#include "tools/suite/sequences.h"
#include "tools/suite/suite_table.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kMostSettings = 200;

// Names begin with that of their suite; a suite without groups counts as one group.
absl::StatusOr<SequenceList> SequencesOf(const std::vector<std::string>& suites) {
  SequenceList all;
  for (const std::string& suite : suites) {
    EGOSIEVE_ASSIGN_OR_RETURN(const SequenceList list, FindSequences(suite));
    fs::path path = fs::absolute(suite).lexically_normal();
    if (path.filename().empty()) path = path.parent_path();
    const std::string base = path.filename().string();
    for (Sequence sequence : list.sequences) {
      const bool grouped = sequence.group != sequence.name;
      sequence.group = grouped ? absl::StrCat(base, "/", sequence.group) : base;
      sequence.name = absl::StrCat(base, "/", sequence.name);
      all.sequences.push_back(std::move(sequence));
    }
  }
  return all;
}

}  // namespace

absl::StatusOr<std::vector<SettingScore>> ScoreSettings(const TuneDefaultsOptions& options,
                                                        const ProgressFlag& flag) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<Setting> settings,
                            ParseGrid(options.grid, kMostSettings));
  EGOSIEVE_ASSIGN_OR_RETURN(const SequenceList list, SequencesOf(options.suites));
  SuiteOptions suite = options.suite;
  EGOSIEVE_ASSIGN_OR_RETURN(suite.program, OwnProgram());
  suite.variants = {VariantOfProfile(options.profile)};
  suite.cores = kernels::MaximumThreads();
  suite.masks = false;
  Progress progress("tune_defaults", flag,
                    static_cast<int64_t>(settings.size() * list.sequences.size()), "sequence");
  std::vector<SettingScore> scores;
  for (const Setting& setting : settings) {
    suite.out = (fs::path(options.suite.out) / setting.folder).string();
    suite.segment_flags = setting.flags;
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::vector<SequenceResult> results,
        RunSuite(list, suite, InterruptionRequested, [&] { progress.Advance(); }));
    scores.push_back(ScoreOfSetting(setting.name, options.profile, SummariseSuite(results)));
  }
  progress.Finish();
  return scores;
}

}  // namespace egosieve::tools
