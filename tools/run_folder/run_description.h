// Description of a run: run.json.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/image/image_grid.h"

namespace egosieve::tools {

// The format of the whole folder. Readers accept only this format.
inline constexpr int kRunFormat = 2;

struct RunDescription {
  std::string version;                       // of the program
  std::map<std::string, std::string> flags;  // every flag that shapes the output, with its value
  std::string device;                        // device of the dense maps; see FrameLine::map_device
  uint64_t seed = 0;

  struct Input {
    std::string path;                       // as given, made absolute
    std::string kind;                       // video, folder, glob, list or stream
    std::string fingerprint;                // detects another input at the same path
    std::vector<std::string> remarks = {};  // FrameSource::remarks
  } input;

  vision::ImageGrid grid;  // of the maps; its width and height are the frames'

  // A pixel of grid/NNNNNN.prob.png is 65535 p; a pixel of .std.png is 65535 s /
  // deviation_full_scale, where s is the deviation of the latent function f with probability p =
  // Phi(...). Larger values saturate.
  double deviation_full_scale = 4.0;

  // A run that was killed also leaves "running".
  std::string ended = "running";  // running, done, interrupted, failed
  std::string ended_message;      // the error's line if it failed
  int64_t frames_answered = 0;
  int64_t frames_learnt = 0;
  int64_t frames_failed = 0;
  double seconds = 0.0;      // duration of the run, including resumed parts
  std::string started_utc;   // ISO 8601
  std::string finished_utc;  // empty while running
};

std::string ToText(const RunDescription& description);
// DataLoss, naming the field; FailedPrecondition for another format.
absl::StatusOr<RunDescription> RunDescriptionFromText(absl::string_view text);

// The first flag, input or device that differs between the run `before` and its
// continuation `now`: "stride is 5 there and 3 here". Empty if they agree.
std::string DescribeDifference(const RunDescription& before, const RunDescription& now);

}  // namespace egosieve::tools
