// What a run was: run.json.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_RUN_DESCRIPTION_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_RUN_DESCRIPTION_H_

#include <cstdint>
#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "kernels/base/image_grid.h"

namespace egosieve::tools {

// The format of the whole folder; readers refuse later ones.
inline constexpr int kRunFormat = 2;

struct RunDescription {
  std::string version;                       // of the program
  std::map<std::string, std::string> flags;  // every flag that shapes the output, as it was used
  std::string device;                        // that computes the dense maps; FrameLine::map_device
  uint64_t seed = 0;
  // The run folder whose models made the maps, made absolute; empty: this one, in run.json absent.
  std::string maps_from;

  struct Input {
    std::string path;         // as it was given, made absolute
    std::string kind;         // video, folder, glob, list or stream
    std::string fingerprint;  // tells another input at the same path
  } input;

  kernels::ImageGrid grid;  // of the maps; its width and height are the frames'

  // A pixel of grid/NNNNNN.prob.png is 65535 p; of .std.png 65535 s / deviation_full_scale, where s
  // is the deviation of the latent function f, whose probability p = Phi(...) is; larger saturate.
  double deviation_full_scale = 4.0;

  // "running" is also what a run that was killed leaves.
  std::string ended = "running";  // running, done, interrupted, failed
  std::string ended_message;      // the error's line where it failed
  int64_t frames_answered = 0;
  int64_t frames_learnt = 0;
  int64_t frames_failed = 0;
  double seconds = 0.0;      // all that the run took, resumed parts included
  std::string started_utc;   // ISO 8601
  std::string finished_utc;  // empty while running
};

// Whether the run leaves maps to be made later, and so keeps its models.
bool KeepsModels(const RunDescription& description);

std::string ToText(const RunDescription& description);
// DataLoss, naming the field; FailedPrecondition for a later format.
absl::StatusOr<RunDescription> RunDescriptionFromText(absl::string_view text);

// The first flag, input, device or source of models in which a run that is to be continued differs
// from the one that `before` describes: "stride is 5 there and 3 here". Empty where they agree.
std::string DescribeDifference(const RunDescription& before, const RunDescription& now);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_RUN_DESCRIPTION_H_
