// A TOML text as a flat list of its entries, in the order of the text.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

struct TomlEntry {
  std::vector<std::string> path;    // the names of the entry's tables, then its own
  std::vector<std::string> values;  // as text; one, except in arrays
  bool is_array = false;
  int line = 0;
};

// InvalidArgument, naming the line, for text that is not TOML, and for dates and arrays of arrays or
// tables, which no flag accepts.
absl::StatusOr<std::vector<TomlEntry>> ReadTomlEntries(absl::string_view text);

}  // namespace egosieve::tools
