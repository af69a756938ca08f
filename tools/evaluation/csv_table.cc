#include "tools/evaluation/csv_table.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"

namespace egosieve::tools {
namespace {

constexpr size_t kAbsent = static_cast<size_t>(-1);

class CsvReader {
 public:
  explicit CsvReader(absl::string_view csv) : rest_(csv) {}

  // All fields of the next row. There is always a first one.
  absl::StatusOr<CsvRow> Read() {
    CsvRow row;
    row.line = line_;
    do {
      std::string text;
      if (const absl::Status status = ReadField(&text); !status.ok())
        return row.Bad(status.message());
      row.texts.push_back(std::move(text));
    } while (Take(','));
    at_end_ = !Take('\n');
    return row;
  }

  bool at_end() const { return at_end_; }

 private:
  bool Take(char c) {
    if (rest_.empty() || rest_.front() != c) return false;
    rest_.remove_prefix(1);
    line_ += c == '\n';
    return true;
  }

  // Up to the comma or the line break that ends the field.
  absl::string_view TakePlain() {
    const absl::string_view plain = rest_.substr(0, rest_.find_first_of(",\n"));
    rest_.remove_prefix(plain.size());
    return absl::StripAsciiWhitespace(plain);
  }

  absl::Status ReadField(std::string* text) {
    const size_t begin = rest_.find_first_not_of(" \t\r\v\f");
    if (begin == absl::string_view::npos || rest_[begin] != '"') {
      *text = std::string(TakePlain());
      return absl::OkStatus();
    }
    rest_.remove_prefix(begin + 1);
    for (;;) {
      const size_t end = rest_.find('"');
      if (end == absl::string_view::npos) return absl::DataLossError("a quote is not closed");
      const absl::string_view part = rest_.substr(0, end);
      line_ += std::count(part.begin(), part.end(), '\n');
      absl::StrAppend(text, part);
      rest_.remove_prefix(end + 1);
      if (!Take('"')) break;
      text->push_back('"');
    }
    if (!TakePlain().empty()) return absl::DataLossError("text follows a closed quote");
    return absl::OkStatus();
  }

  absl::string_view rest_;
  int64_t line_ = 1;
  bool at_end_ = false;
};

size_t PlaceOf(const std::string& name, const std::vector<std::string>& header) {
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
  CsvReader reader(csv);
  const absl::StatusOr<CsvRow> header = reader.Read();
  if (!header.ok()) return header.status();
  std::vector<size_t> places;
  for (const std::string& name : required) {
    places.push_back(PlaceOf(name, header->texts));
    if (places.back() != kAbsent) continue;
    return absl::DataLossError(absl::StrCat("line 1 has no field \"", name,
                                            "\"; it must be: ", absl::StrJoin(required, ",")));
  }
  for (const std::string& name : optional) places.push_back(PlaceOf(name, header->texts));
  std::vector<CsvRow> rows;
  while (!reader.at_end()) {
    absl::StatusOr<CsvRow> read = reader.Read();
    if (!read.ok()) return read.status();
    if (read->texts.size() == 1 && read->texts.front().empty()) continue;
    CsvRow row;
    row.line = read->line;
    for (size_t field = 0; field < places.size(); ++field) {
      const bool there = places[field] < read->texts.size();
      if (!there && field < required.size()) return row.Bad("no " + required[field]);
      row.texts.emplace_back(there ? read->texts[places[field]] : "");
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string CsvField(absl::string_view text) {
  const bool plain = text.find_first_of(",\"\r\n") == absl::string_view::npos &&
                     text == absl::StripAsciiWhitespace(text);
  if (plain) return std::string(text);
  return absl::StrCat("\"", absl::StrReplaceAll(text, {{"\"", "\"\""}}), "\"");
}

}  // namespace egosieve::tools
