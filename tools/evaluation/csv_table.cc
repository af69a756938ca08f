#include "tools/evaluation/csv_table.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"

namespace egosieve::tools {
namespace {

using Columns = std::vector<absl::string_view>;

constexpr size_t kAbsent = static_cast<size_t>(-1);

Columns Split(absl::string_view line) {
  Columns columns = absl::StrSplit(line, ',');
  for (absl::string_view& column : columns) column = absl::StripAsciiWhitespace(column);
  return columns;
}

size_t PlaceOf(const std::string& name, const Columns& header) {
  const auto found = std::find(header.begin(), header.end(), name);
  return found == header.end() ? kAbsent : static_cast<size_t>(found - header.begin());
}

}  // namespace

absl::Status CsvRow::Bad(absl::string_view what) const {
  return absl::DataLossError(absl::StrCat("line ", line, ": ", what));
}

absl::StatusOr<std::vector<CsvRow>> ParseCsv(absl::string_view csv,
                                             const std::vector<std::string>& required,
                                             const std::vector<std::string>& optional) {
  const std::vector<absl::string_view> lines = absl::StrSplit(csv, '\n');
  const Columns header = Split(absl::StripAsciiWhitespace(lines.front()));
  std::vector<size_t> places;
  for (const std::string& name : required) {
    places.push_back(PlaceOf(name, header));
    if (places.back() != kAbsent) continue;
    return absl::DataLossError(absl::StrCat("line 1 has no field \"", name,
                                            "\"; it must be: ", absl::StrJoin(required, ",")));
  }
  for (const std::string& name : optional) places.push_back(PlaceOf(name, header));
  std::vector<CsvRow> rows;
  for (size_t k = 1; k < lines.size(); ++k) {
    const absl::string_view line = absl::StripAsciiWhitespace(lines[k]);
    if (line.empty()) continue;
    CsvRow row;
    row.line = static_cast<int64_t>(k) + 1;
    const Columns columns = Split(line);
    for (size_t field = 0; field < places.size(); ++field) {
      const bool there = places[field] < columns.size();
      if (!there && field < required.size()) return row.Bad("no " + required[field]);
      row.texts.emplace_back(there ? columns[places[field]] : "");
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace egosieve::tools
