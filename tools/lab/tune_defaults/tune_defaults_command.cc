#include "tools/lab/tune_defaults/tune_defaults_command.h"

#include <filesystem>
#include <string>
#include <vector>

#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/lab/tune_defaults/setting_grid.h"
#include "tools/lab/tune_defaults/tune_defaults_run.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

class TuneDefaultsCommand : public Command {
 public:
  std::string name() const override { return "tune_defaults"; }
  std::string summary() const override {
    return "Tries settings of segment on several suites together and ranks them.";
  }
  std::string example() const override {
    return "egosieve lab tune_defaults --suite=shared/data --suite=out/synthetic --out=out/tune "
           "--grid='budget=1000,1500,2000;window=5,7'";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("--suite", options_.suites,
                   "Folder of sequences, as for evaluate; may be repeated")
        ->required()
        ->type_name("DIR");
    app.add_option("--out", options_.suite.out,
                   "Folder for the runs of every setting, and tuning.txt")
        ->required()
        ->type_name("DIR");
    app.add_option("--grid", options_.grid,
                   "Flags of segment and the values to try, FLAG=VALUE,VALUE;FLAG=VALUE: all "
                   "combinations, and the profile as it is")
        ->required()
        ->type_name("GRID");
    app.add_option("--profile", options_.profile, "The profile that the settings change")
        ->capture_default_str();
    app.add_option("--noise", noise_, "Differences in AUC up to this count as equal")
        ->check(Between(0.0, 1.0))
        ->capture_default_str();
    app.add_option("--max_frames", options_.suite.max_frames,
                   "Frames of each sequence at most; 0: all")
        ->check(AtLeast<int64_t>(0))
        ->capture_default_str();
    app.add_option("--jobs", options_.suite.jobs, "Sequences at a time")
        ->check(Between(1, 256))
        ->capture_default_str();
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<SettingScore> scores,
                              ScoreSettings(options_, progress_));
    const std::string table = RankTable(scores, noise_);
    const std::string path = (std::filesystem::path(options_.suite.out) / "tuning.txt").string();
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(path, table));
    result_.Tell(name(), {{"settings", scores.size()}, {"table", path}}, table);
    return ExitCode::kDone;
  }

 private:
  TuneDefaultsOptions options_;
  double noise_ = 0.01;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeTuneDefaultsCommand() {
  return std::make_unique<TuneDefaultsCommand>();
}

}  // namespace egosieve::tools
