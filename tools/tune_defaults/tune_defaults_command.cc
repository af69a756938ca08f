#include "tools/tune_defaults/tune_defaults_command.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/suite/child_process.h"
#include "tools/suite/suite_run.h"
#include "tools/suite/suite_table.h"
#include "tools/tune_defaults/setting_grid.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kMostSettings = 200;

class TuneDefaultsCommand : public Command {
 public:
  std::string name() const override { return "tune_defaults"; }
  std::string summary() const override {
    return "Tries settings of segment on several suites together and ranks them.";
  }
  std::string example() const override {
    return "egosieve tune_defaults --suite=shared/data --suite=out/synthetic --out=out/tune "
           "--grid='budget=1000,1500,2000;window=5,7'";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("--suite", suites_, "Folder of sequences, as for evaluate; may be repeated")
        ->required()
        ->type_name("DIR");
    app.add_option("--out", options_.out, "Folder for the runs of every setting, and tuning.txt")
        ->required()
        ->type_name("DIR");
    app.add_option("--grid", grid_,
                   "Flags of segment and the values to try, FLAG=VALUE,VALUE;FLAG=VALUE: all "
                   "combinations, and the profile as it is")
        ->required()
        ->type_name("GRID");
    app.add_option("--profile", profile_, "The profile that the settings change")
        ->capture_default_str();
    app.add_option("--noise", noise_, "Differences in AUC up to this count as equal")
        ->check(Between(0.0, 1.0))
        ->capture_default_str();
    app.add_option("--max_frames", options_.max_frames, "Frames of each sequence at most; 0: all")
        ->check(AtLeast<int64_t>(0))
        ->capture_default_str();
    app.add_option("--jobs", options_.jobs, "Sequences at a time")
        ->check(Between(1, 256))
        ->capture_default_str();
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<Setting> settings, ParseGrid(grid_, kMostSettings));
    EGOSIEVE_ASSIGN_OR_RETURN(const SequenceList list, AllSequences());
    EGOSIEVE_ASSIGN_OR_RETURN(options_.program, OwnProgram());
    options_.variants = {VariantOfProfile(profile_)};
    options_.cores = kernels::MaximumThreads();
    options_.masks = false;
    const std::string out = options_.out;
    Progress progress("tune_defaults", progress_,
                      static_cast<int64_t>(settings.size() * list.sequences.size()), "sequence");
    std::vector<SettingScore> scores;
    for (const Setting& setting : settings) {
      options_.out = (fs::path(out) / setting.folder).string();
      options_.segment_flags = setting.flags;
      EGOSIEVE_ASSIGN_OR_RETURN(
          const std::vector<SequenceResult> results,
          RunSuite(list, options_, InterruptionRequested, [&] { progress.Advance(); }));
      scores.push_back(ScoreOfSetting(setting.name, profile_, SummariseSuite(results)));
    }
    progress.Finish();
    const std::string table = RankTable(scores, noise_);
    const std::string path = (fs::path(out) / "tuning.txt").string();
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(path, table));
    result_.Tell(name(), {{"settings", scores.size()}, {"table", path}}, table);
    return ExitCode::kDone;
  }

 private:
  // Names begin with that of their suite; a suite without groups counts as one group.
  absl::StatusOr<SequenceList> AllSequences() const {
    SequenceList all;
    for (const std::string& suite : suites_) {
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

  std::vector<std::string> suites_;
  std::string grid_;
  std::string profile_ = "default";
  double noise_ = 0.01;
  SuiteOptions options_;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeTuneDefaultsCommand() {
  return std::make_unique<TuneDefaultsCommand>();
}

}  // namespace egosieve::tools
