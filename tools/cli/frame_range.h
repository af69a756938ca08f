// The flags --from and --to: which frames of a drive a command works on.
#ifndef EGOSIEVE_TOOLS_CLI_FRAME_RANGE_H_
#define EGOSIEVE_TOOLS_CLI_FRAME_RANGE_H_

#include <CLI/CLI.hpp>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "tools/cli/checks.h"

namespace egosieve::tools {

struct FrameRange {
  int64_t from = 0;  // index of the first frame
  int64_t to = -1;   // index of the last frame; -1: the last of the drive

  bool Contains(int64_t index) const { return index >= from && (to < 0 || index <= to); }

  void AddFlags(CLI::App& app) {
    app.add_option("--from", from, "Index of the first frame")
        ->check(AtLeast<int64_t>(0))
        ->type_name("FRAME");
    app.add_option("--to", to, "Index of the last frame; -1: the last of the drive")
        ->check(AtLeast<int64_t>(-1))
        ->type_name("FRAME");
  }

  absl::Status Validate() const {
    if (to >= 0 && to < from) {
      return absl::InvalidArgumentError(
          absl::StrCat("--to=", to, " comes before --from=", from, "; exchange them"));
    }
    return absl::OkStatus();
  }
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_FRAME_RANGE_H_
