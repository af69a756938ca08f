// Many sequences under several variants of segment, profiles or others: each is segmented where no
// run of it is there yet, then evaluated.
//
//   out/runs/VARIANT/NAME       the run folder; an existing one is continued or used as it is
//   out/runs/VARIANT/egosieve_logs/NAME.log   what segmenting printed; NAME.masks.log: what
//                                             reconstruct printed
//
// `jobs` sequences at a time, each segmented by a process of its own with its share of the cores:
// one that crashes fails alone. The results' order does not depend on how long each took.
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

// One way to call segment; its name is that of a folder.
struct SuiteVariant {
  std::string name;
  std::vector<std::string> flags;
};

// Frames per second of a sequence: what camera.json beside its frames says, else 10, as segment
// takes it for a folder of images. DataLoss for a camera.json that is damaged.
absl::StatusOr<double> RateOf(const Sequence& sequence);

SuiteVariant VariantOfProfile(const std::string& profile);
// "NAME=FLAGS", flags by spaces. InvalidArgument where the name is not made of letters, digits,
// '_', '-' and '+', or is missing.
absl::StatusOr<SuiteVariant> ParseVariant(absl::string_view text);

struct SuiteOptions {
  std::string program;  // that has the command `segment`
  std::string out;      // the folder that is written
  std::vector<SuiteVariant> variants = {VariantOfProfile("paper"), VariantOfProfile("default")};
  std::vector<std::string> segment_flags;  // passed on to every segmentation
  int jobs = 1;                            // 1 to 256
  int cores = 1;                           // shared by the jobs
  int64_t max_frames = 0;                  // of each sequence; 0: all
  double max_seconds = 0.0;                // likewise, at the sequence's rate
  bool masks = true;                       // made by reconstruct, and scored
  EvaluateOptions evaluate;
  FurtherOptions further;
  std::string true_camera;  // for sequences that have poses, but no camera.json; empty: none

  absl::Status Validate() const;
};

struct SequenceResult {
  Sequence sequence;
  std::string profile;               // name of the variant
  absl::Status status;               // what failed, segmenting or evaluating
  std::optional<RunEvaluation> run;  // where nothing did
  FurtherScores further;             // likewise
  int64_t frames = 0;                // of the run
  double seconds_per_frame = 0.0;    // of segmenting, wall clock
};

// One result a sequence and variant, variants within sequences. A sequence that fails has its
// reason; Cancelled where `stop_requested` became true. `after_sequence` is called by one thread at
// a time.
absl::StatusOr<std::vector<SequenceResult>> RunSuite(const SequenceList& list,
                                                     const SuiteOptions& options,
                                                     const std::function<bool()>& stop_requested,
                                                     const std::function<void()>& after_sequence);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SUITE_SUITE_RUN_H_
