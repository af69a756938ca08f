// Prints a warning, one line on stderr; the command continues.
#ifndef EGOSIEVE_TOOLS_CLI_WARNING_H_
#define EGOSIEVE_TOOLS_CLI_WARNING_H_

#include <iostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "tools/cli/exit_code.h"

namespace egosieve::tools {

// Prints nothing if the message is empty.
inline void Warn(absl::string_view message) {
  if (!message.empty()) std::cerr << ErrorLine(absl::StrCat("warning: ", message)) << "\n";
}

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_WARNING_H_
