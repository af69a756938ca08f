// The flags --from and --to: which frames of a drive a command works on.
#pragma once

#include <cstdint>

#include "absl/status/status.h"

namespace CLI {
class App;
}

namespace egosieve::tools {

struct FrameRange {
  int64_t from = 0;  // index of the first frame
  int64_t to = -1;   // index of the last frame; -1: the last of the drive

  bool Contains(int64_t index) const { return index >= from && (to < 0 || index <= to); }

  void AddFlags(CLI::App& app);

  absl::Status Validate() const;
};

}  // namespace egosieve::tools
