// Runs many sequences with several variants of segment, such as profiles. Each sequence is
// segmented if it has no run yet, and then evaluated.
//
//   out/runs/VARIANT/NAME       the run folder; an existing one is continued or used as it is
//   out/runs/VARIANT/egosieve_logs/NAME.log   output of segmenting; NAME.masks.log: output of
//                                             reconstruct
//
// `jobs` sequences run at a time, each segmented by a process of its own with its share of the
// cores. A crash affects only its own sequence. The order of the results does not depend on
// durations.
#ifndef EGOSIEVE_TOOLS_SUITE_SUITE_RUN_H_
#define EGOSIEVE_TOOLS_SUITE_SUITE_RUN_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "tools/evaluate/evaluate_run.h"
#include "tools/evaluate/further_truth.h"
#include "tools/suite/sequences.h"

namespace egosieve::tools {

// One set of flags of segment; its name is that of a folder.
struct SuiteVariant {
  std::string name;
  std::vector<std::string> flags;
};

// Frames per second of a sequence: from camera.json beside its frames, else 10, which is also
// segment's rate for a folder of images. DataLoss if camera.json is damaged.
absl::StatusOr<double> RateOf(const Sequence& sequence);

SuiteVariant VariantOfProfile(const std::string& profile);
// Parses "NAME=FLAGS", flags separated by spaces. InvalidArgument if the name is missing or has
// other characters than letters, digits, '_', '-' and '+'.
absl::StatusOr<SuiteVariant> ParseVariant(absl::string_view text);
// The profiles, named by commas, then the variants.
absl::StatusOr<std::vector<SuiteVariant>> ParseVariants(absl::string_view profiles,
                                                        const std::vector<std::string>& variants);

struct SuiteOptions {
  std::string program;  // a program with the command `segment`
  std::string out;      // the output folder
  std::vector<SuiteVariant> variants = {VariantOfProfile("paper"), VariantOfProfile("default")};
  std::vector<std::string> segment_flags;  // passed on to every segmentation
  int jobs = 1;                            // 1 to 256
  int cores = 1;                           // shared by the jobs
  int64_t max_frames = 0;                  // of each sequence; 0: all
  double max_seconds = 0.0;                // likewise, at the sequence's rate
  bool masks = true;                       // made by reconstruct, and scored
  EvaluateOptions evaluate;
  FurtherOptions further;
  std::string true_camera;  // for sequences with poses but without camera.json; empty: none

  absl::Status Validate() const;
};

struct SequenceResult {
  Sequence sequence;
  std::string profile;               // name of the variant
  absl::Status status;               // error of segmenting or evaluating
  std::optional<RunEvaluation> run;  // if there was no error
  FurtherScores further;             // likewise
  int64_t frames = 0;                // of the run
  double seconds_per_frame = 0.0;    // of segmenting, wall clock
};

// One result per sequence and variant, variants within sequences. A failed sequence has its reason.
// Cancelled if `stop_requested` became true. `after_sequence` is called by one thread at a time.
absl::StatusOr<std::vector<SequenceResult>> RunSuite(const SequenceList& list,
                                                     const SuiteOptions& options,
                                                     const std::function<bool()>& stop_requested,
                                                     const std::function<void()>& after_sequence);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SUITE_SUITE_RUN_H_
