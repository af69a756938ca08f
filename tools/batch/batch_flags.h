// The flags of `batch`: which drives, what is run on them, where and how many at the same time.
#ifndef EGOSIEVE_TOOLS_BATCH_BATCH_FLAGS_H_
#define EGOSIEVE_TOOLS_BATCH_BATCH_FLAGS_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/batch/manifest.h"
#include "tools/batch/plan_run.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/result_flag.h"

namespace egosieve::tools {

struct BatchFlags {
  struct Drives {
    std::vector<BatchEntry> entries;
    std::vector<std::string> left_out;  // the inputs that are not drives
  };

  std::vector<std::string> inputs;
  std::string out, then, segment_flags, masks_flags;
  std::string index;  // empty: DefaultIndexPath
  int jobs = 1;
  PlanRun plan_run;
  ResultFlag result;

  void AddFlags(CLI::App& app);

  // The drives of all inputs, in their order. InvalidArgument for flags and manifests that do not
  // fit, if two drives have the same run folder, and if --out is missing where it is needed; else
  // the errors of ReadManifest and FindDrives.
  absl::StatusOr<Drives> FindEntries() const;
  // Runs the plan of `entries` outside this process. InvalidArgument if there are several inputs.
  absl::StatusOr<ExitCode> RunPlan(const std::vector<BatchEntry>& entries) const;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_BATCH_FLAGS_H_
