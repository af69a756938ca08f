// Truth files: a header of field names, then one line per row, fields separated by commas in any
// order; unknown fields are ignored.
#ifndef EGOSIEVE_TOOLS_EVALUATION_CSV_TABLE_H_
#define EGOSIEVE_TOOLS_EVALUATION_CSV_TABLE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

struct CsvRow {
  int64_t line = 0;                // in the file, from 1
  std::vector<std::string> texts;  // of the required fields, then of the optional ones

  // DataLoss: "line N: what".
  absl::Status Bad(absl::string_view what) const;
};

// Empty lines are skipped. An optional field that the header lacks is empty in every row. DataLoss,
// naming the line and the field, if a required field is missing.
absl::StatusOr<std::vector<CsvRow>> ParseCsv(absl::string_view csv,
                                             const std::vector<std::string>& required,
                                             const std::vector<std::string>& optional = {});

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_CSV_TABLE_H_
