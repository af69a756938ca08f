// The release, as printed by --version and written to run.json.
#ifndef EGOSIEVE_TOOLS_CLI_VERSION_H_
#define EGOSIEVE_TOOLS_CLI_VERSION_H_

namespace egosieve::tools {

inline constexpr char kVersion[] = "0.1.0";

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_VERSION_H_
