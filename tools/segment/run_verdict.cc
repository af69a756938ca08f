#include "tools/segment/run_verdict.h"

#include "absl/strings/str_cat.h"

namespace egosieve::tools {
RunVerdict JudgeRun(const DriveWriter::Counts& counts, const std::string& end_warning) {
  RunVerdict verdict;
  if (counts.other_sizes > 0) {
    verdict.warnings.push_back(
        absl::StrCat(counts.other_sizes, " of ", counts.answered,
                     " frames are of another size than the first; their maps have their size"));
  }
  const std::string too_few = counts.doubtful.TooFewLearnt();
  const bool learnt_nothing = counts.answered > 0 && counts.learnt == 0;
  if (learnt_nothing) {
    verdict.warnings.push_back(
        absl::StrCat("nothing was learnt, so every map is the prior: ", counts.last_not_learnt,
                     "; give frames of a moving camera, two at least"));
  } else if (!too_few.empty()) {
    verdict.warnings.push_back(absl::StrCat(too_few, "; the masks are not to be relied on"));
  } else if (const std::string sparse = counts.baselines.Describe(); !sparse.empty()) {
    verdict.warnings.push_back(sparse);
  }
  bool failed = counts.failed > 0 || learnt_nothing || !too_few.empty();
  if (counts.failed > 0) {
    verdict.warnings.push_back(
        absl::StrCat(counts.failed,
                     " frames could not be read and have the map of the frame "
                     "before: ",
                     counts.first_failure));
  }
  if (!end_warning.empty()) {
    verdict.warnings.push_back(end_warning);
    failed = true;
  }
  if (failed) verdict.code = ExitCode::kFramesFailed;
  return verdict;
}

}  // namespace egosieve::tools
