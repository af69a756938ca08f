// The work of `egosieve lab compare`: finds the drives, makes the synthetic ones, and compares the
// methods on every drive under every profile.
#ifndef EGOSIEVE_TOOLS_LAB_COMPARE_COMPARE_RUN_H_
#define EGOSIEVE_TOOLS_LAB_COMPARE_COMPARE_RUN_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"
#include "tools/cli/progress.h"
#include "tools/lab/compare/block_bootstrap.h"
#include "tools/lab/compare/drive_comparison.h"
#include "tools/lab/compare/profile_comparison.h"

namespace egosieve::tools {

// A profile or another variant of segment.
struct ComparedProfile {
  std::string name;
  ComparisonOptions options;
};

struct CompareOptions {
  std::string input;  // frames, if there is a truth, else a folder of sequences, else empty
  std::string truth;
  std::string out;
  bool make_drives = false;            // the scenarios are drives, beside those of the input
  std::vector<std::string> scenarios;  // made in out/drives
  int drive_frames = 150;
  uint64_t drive_seed = 1;
  std::vector<ComparedProfile> profiles;  // at least one, all with the same methods
  BootstrapOptions bootstrap;
  int jobs = 1;  // drives at a time
};

// One comparison per profile, with a result per drive, which has its reason if it failed. An error
// of the only drive is an error of the whole. Cancelled if interrupted.
absl::StatusOr<std::vector<ProfileComparison>> RunComparison(
    const std::shared_ptr<kernels::Context>& context, const CompareOptions& options,
    const ProgressFlag& progress);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_COMPARE_COMPARE_RUN_H_
