// The flags of `batch` that run its plan elsewhere than in this process, and what they do.
//
//   --engine=slurm   measures, writes the scripts of job arrays, submits them
//   --task=K         becomes the program of one task
//   --plan           prints the tasks with their numbers
//   --status         prints how far each drive is
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

  // Whether the flags ask for anything that Run does.
  bool IsAskedFor() const;
  // InvalidArgument where drives are to be learnt in pieces, which is done by plans alone.
  absl::Status CheckUncut(const std::vector<BatchEntry>& entries) const;
  // `manifest`: its path, beside which egosieve_jobs/ is written.
  absl::StatusOr<ExitCode> Run(const std::string& manifest, std::vector<BatchEntry> entries,
                               const ResultFlag& result) const;

 private:
  absl::StatusOr<ExitCode> RunTask(const BatchPlan& plan) const;
  absl::StatusOr<ExitCode> TellPlan(const BatchPlan& plan, const ResultFlag& result) const;
  absl::StatusOr<ExitCode> TellStatus(const BatchPlan& plan, const std::string& folder,
                                      const ResultFlag& result) const;
  absl::StatusOr<ExitCode> SubmitPlan(const BatchPlan& plan, const std::string& folder,
                                      const ResultFlag& result) const;

  std::string engine_ = "local";
  int shards_ = 2;
  int cpus_ = 0;
  CutOptions cut_;  // beside those drives that the manifest cuts
  std::optional<int64_t> task_;
  bool plan_ = false;
  bool status_ = false;
  bool dry_run_ = false;
  int64_t measured_frames_ = 40;
  std::string sbatch_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_PLAN_RUN_H_
