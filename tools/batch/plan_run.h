// The flags of `batch` that run its plan outside this process, and their implementation.
//
//   --engine=slurm   measures costs, writes the scripts of job arrays, submits them
//   --task=K         becomes the program of one task
//   --plan           prints the tasks with their numbers
//   --status         prints the progress of each drive
#ifndef EGOSIEVE_TOOLS_BATCH_PLAN_RUN_H_
#define EGOSIEVE_TOOLS_BATCH_PLAN_RUN_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/batch/drive_cuts.h"
#include "tools/batch/manifest.h"
#include "tools/batch/plan.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/result_flag.h"

namespace egosieve::tools {

class PlanRun {
 public:
  void AddFlags(CLI::App& app);

  // Whether a flag is given that Run implements.
  bool IsAskedFor() const;
  // For drives that run without a plan: InvalidArgument if they are to be learnt in pieces or a
  // flag is given that only plans use.
  absl::Status CheckUnplanned(const std::vector<BatchEntry>& entries) const;
  // `manifest`: its path; egosieve_jobs/ is written beside it.
  absl::StatusOr<ExitCode> Run(const std::string& manifest, std::vector<BatchEntry> entries,
                               const ResultFlag& result) const;

 private:
  absl::StatusOr<ExitCode> RunTask(const BatchPlan& plan) const;
  absl::StatusOr<ExitCode> TellPlan(const BatchPlan& plan, const ResultFlag& result) const;
  absl::StatusOr<ExitCode> TellStatus(const BatchPlan& plan, const std::string& folder,
                                      const ResultFlag& result) const;
  absl::StatusOr<ExitCode> SubmitPlan(const BatchPlan& plan, const std::string& folder,
                                      const ResultFlag& result) const;

  std::vector<CLI::Option*> of_plans_;  // flags that have no effect without a plan
  std::string engine_ = "local";
  int cpus_ = 0;
  CutOptions cut_;  // for drives that the manifest does not cut
  std::optional<int64_t> task_;
  bool plan_ = false;
  bool status_ = false;
  bool dry_run_ = false;
  int64_t measured_frames_ = 40;
  std::string sbatch_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_PLAN_RUN_H_
