// The release, as printed by --version and written to run.json.
#pragma once

namespace egosieve::tools {

inline constexpr char kVersion[] = "0.1.0";

}  // namespace egosieve::tools
