// Tables of text (RFC 4180): a header of field names, then one row per line, fields separated by
// commas. A field in double quotes may hold commas, line breaks and, doubled, double quotes.
// Truth files have their fields in any order; unknown fields are ignored.
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
  int64_t line = 0;                // where it begins in the file, from 1
  std::vector<std::string> texts;  // of the required fields, then of the optional ones

  // DataLoss: "line N: what".
  absl::Status Bad(absl::string_view what) const;
};

// Empty lines are skipped, and so is white space around a field, but not within its quotes. An
// optional field that the header lacks is empty in every row. DataLoss, naming the line and the
// field, if a required field is missing or a quote is not closed.
absl::StatusOr<std::vector<CsvRow>> ParseCsv(absl::string_view csv,
                                             const std::vector<std::string>& required,
                                             const std::vector<std::string>& optional = {});

// The text as a field of a row: in quotes where ParseCsv would otherwise read something else.
std::string CsvField(absl::string_view text);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_CSV_TABLE_H_
