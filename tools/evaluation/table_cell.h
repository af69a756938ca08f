// A cell of a table of figures that is printed in a font of one width.
#ifndef EGOSIEVE_TOOLS_EVALUATION_TABLE_CELL_H_
#define EGOSIEVE_TOOLS_EVALUATION_TABLE_CELL_H_

#include <optional>
#include <string>

#include "absl/strings/str_format.h"

namespace egosieve::tools {

// A space, then the value at the right of `width` characters; "-" without a value.
inline std::string TableCell(const std::optional<double>& value, int width = 8, int decimals = 4) {
  return value ? absl::StrFormat(" %*.*f", width, decimals, *value)
               : absl::StrFormat(" %*s", width, "-");
}

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_TABLE_CELL_H_
