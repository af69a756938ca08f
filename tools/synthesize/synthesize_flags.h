// The flags of `synthesize`: the scenario, its rendering, and the folder to write.
#ifndef EGOSIEVE_TOOLS_SYNTHESIZE_SYNTHESIZE_FLAGS_H_
#define EGOSIEVE_TOOLS_SYNTHESIZE_SYNTHESIZE_FLAGS_H_

#include "absl/status/statusor.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/synthesize/synthesize.h"

namespace CLI {
class App;
}

namespace egosieve::tools {

struct SynthesizeFlags {
  SynthesizeOptions options;
  bool list = false;     // the scenarios, and nothing else
  double seconds = 0.0;  // instead of a number of frames; 0: that number
  ProgressFlag progress;
  ResultFlag result;

  void AddFlags(CLI::App& app);
  // The options, with the frames of `seconds`. InvalidArgument without an output folder.
  absl::StatusOr<SynthesizeOptions> MakeOptions() const;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SYNTHESIZE_SYNTHESIZE_FLAGS_H_
