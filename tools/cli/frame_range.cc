#include "tools/cli/frame_range.h"

#include <CLI/CLI.hpp>

#include "absl/strings/str_cat.h"
#include "tools/cli/checks.h"

namespace egosieve::tools {

void FrameRange::AddFlags(CLI::App& app) {
  app.add_option("--from", from, "Index of the first frame")
      ->check(AtLeast<int64_t>(0))
      ->type_name("FRAME");
  app.add_option("--to", to, "Index of the last frame; -1: the last of the drive")
      ->check(AtLeast<int64_t>(-1))
      ->type_name("FRAME");
}

absl::Status FrameRange::Validate() const {
  if (to >= 0 && to < from) {
    return absl::InvalidArgumentError(
        absl::StrCat("--to=", to, " comes before --from=", from, "; exchange them"));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::tools
