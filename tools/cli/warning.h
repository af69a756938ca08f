// Prints a warning, one line on stderr; the command continues.
#pragma once

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
