// The flags of `masks`: which masks of an input or a run are written, for which program.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/masks/mask_export.h"

namespace CLI {
class App;
}

namespace egosieve::tools {

enum class Treatment { kDefault, kKeep, kMask };

struct MasksFlags {
  std::string input;  // a video, images, or a run folder
  std::string run;    // the run folder of an input that is segmented; empty: OUT.run
  std::string moved;  // where the run's input is now; empty: where run.json says
  MaskExportOptions options;
  Treatment unsure = Treatment::kDefault, own_vehicle = Treatment::kDefault;
  // Flags for segment, and for segment and refine, with their values if given.
  std::map<std::string, std::optional<std::string>> passed, passed_to_both;
  ProgressFlag progress;
  ResultFlag result;

  void AddFlags(CLI::App& app);

  // Sets those `options` that other flags decide. InvalidArgument if flags exclude each other.
  absl::Status Resolve();
  // InvalidArgument for flags that do not belong to an input that is a run folder.
  absl::Status CheckForRun() const;
};

}  // namespace egosieve::tools
