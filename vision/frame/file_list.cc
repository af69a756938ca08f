#include "vision/frame/file_list.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "absl/time/time.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "vision/frame/image_decoding.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMaximumBytes = int64_t{1} << 30;
constexpr size_t kNanosecondDigits = 18;

struct Line {
  std::string place, text;  // "list.txt, line 3: "
};

absl::StatusOr<std::vector<Line>> ReadLines(const std::string& path) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, kernels::ReadFile(path, kMaximumBytes));
  std::vector<Line> lines;
  size_t number = 0;
  absl::string_view rest = text;
  if (absl::StartsWith(rest, "\xff\xfe") || absl::StartsWith(rest, "\xfe\xff")) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, " is written in UTF-16; save it as UTF-8"));
  }
  absl::ConsumePrefix(&rest, "\xef\xbb\xbf");
  for (const absl::string_view row : absl::StrSplit(rest, '\n')) {
    ++number;
    const absl::string_view content = absl::StripAsciiWhitespace(row);
    if (content.empty() || content.front() == '#') continue;
    lines.push_back({absl::StrCat(path, ", line ", number, ": "), std::string(content)});
  }
  return lines;
}

absl::Status LineError(const Line& line, const std::string& what) {
  return absl::InvalidArgumentError(line.place + what);
}

std::optional<double> TimeOf(absl::string_view text) {
  if (text.size() >= kNanosecondDigits &&
      std::all_of(text.begin(), text.end(), absl::ascii_isdigit)) {
    int64_t nanoseconds = 0;
    if (absl::SimpleAtoi(text, &nanoseconds)) return static_cast<double>(nanoseconds) * 1e-9;
  }
  double seconds = 0.0;
  if (absl::SimpleAtod(text, &seconds) && std::isfinite(seconds)) return seconds;
  absl::Time time;
  if (absl::ParseTime("%Y-%m-%d %H:%M:%E*S", text, &time, nullptr)) {
    return absl::ToDoubleSeconds(time - absl::UnixEpoch());
  }
  return std::nullopt;
}

// Fields between the separators, which may be quoted; "" is a quote within quotes. Several spaces
// separate once.
std::vector<std::string> FieldsOf(absl::string_view text, char separator) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    std::string& field = fields.back();
    if (text[i] == '"' && (is_quoted || field.empty())) {
      const bool is_quote = is_quoted && i + 1 < text.size() && text[i + 1] == '"';
      if (is_quote) field.push_back(text[i++]);
      is_quoted = is_quote || !is_quoted;
    } else if (text[i] == separator && !is_quoted) {
      if (separator != ' ' || !field.empty()) fields.emplace_back();
    } else {
      field.push_back(text[i]);
    }
  }
  for (std::string& field : fields) absl::StripAsciiWhitespace(&field);
  return fields;
}

// The separator of a list's fields: the first of these that the line has.
char SeparatorOf(absl::string_view text) {
  for (const char separator : {',', ';', '\t'}) {
    if (absl::StrContains(text, separator)) return separator;
  }
  return ' ';
}

bool NamesAFile(const std::string& name) {
  return HasImageExtension(name) || HasVideoExtension(name);
}

// By the last folder's and the file's name: those above may be anything.
std::string SideKindOf(const fs::path& name) {
  return SideKind((name.parent_path().filename() / name.filename()).string());
}

struct Entry {
  std::string path;  // empty: no file is named
  std::string name;  // as it stands in the line
  std::optional<double> time;
  size_t other_files = 0;  // in further columns
};

// Reads the lines of one list.
class ListReader {
 public:
  // Absolute paths: those of some lines may be.
  explicit ListReader(const std::string& list) : folder_(fs::absolute(list).parent_path()) {}

  // Whether the first line holds the names of columns; remembers them.
  bool IsHeader(const std::string& text) {
    if (!PathOf(text).empty()) return false;
    const std::vector<std::string> fields = FieldsOf(text, SeparatorOf(text));
    for (const std::string& field : fields) {
      if (TimeOf(field) || NamesAFile(field) || absl::StrContains(field, '/')) return false;
    }
    for (size_t i = 0; i < fields.size(); ++i) {
      const std::string name = absl::AsciiStrToLower(fields[i]);
      if (!time_column_ && absl::StrContains(name, "time")) time_column_ = i;
    }
    constexpr std::string_view kNames[] = {"file", "filename", "file_name", "image",  "image_name",
                                           "name", "path",     "file_path", "picture"};
    return fields.size() > 1 || std::count(std::begin(kNames), std::end(kNames), text) > 0;
  }

  Entry EntryOf(const std::string& text) const {
    if (const std::string path = PathOf(text); !path.empty()) return {path, text, {}, 0};
    // A name may hold the separator: all that follows a time, or comes before it.
    const char separator = SeparatorOf(text);
    for (const char cut : {separator, ' '}) {
      for (const size_t at :
           {text.find(cut), text.find(cut, text.find(cut) + 1), text.rfind(cut)}) {
        if (at == std::string::npos) continue;
        const std::string before = Trimmed(text.substr(0, at)),
                          after = Trimmed(text.substr(at + 1));
        for (const auto& [time, name] : {std::pair(before, after), std::pair(after, before)}) {
          const std::string path = PathOf(name);
          const std::optional<double> seconds = TimeOf(time);
          if (!path.empty() && seconds) return {path, name, seconds, 0};
        }
      }
    }
    return EntryOfFields(FieldsOf(text, separator));
  }

 private:
  static std::string Trimmed(const std::string& text) {
    return std::string(absl::StripAsciiWhitespace(text));
  }

  Entry EntryOfFields(const std::vector<std::string>& fields) const {
    Entry entry;
    size_t column = fields.size();
    for (size_t i = 0; i < fields.size(); ++i) {
      const std::string path = PathOf(fields[i]);
      if (path.empty()) continue;
      const bool is_better = SideKindOf(fields[i]).empty() && !SideKindOf(entry.name).empty();
      entry.other_files += column < fields.size();
      if (column < fields.size() && !is_better) continue;
      column = i;
      entry.path = path;
      entry.name = fields[i];
    }
    if (column == fields.size()) {  // no file is there: what it should have been called
      for (const std::string& field : fields) {
        if (entry.name.empty() && NamesAFile(field)) entry.name = field;
      }
      if (fields.size() == 1) entry.name = fields.front();
    }
    for (const size_t i :
         {time_column_.value_or(fields.size()), column - 1, column + 1, size_t{0}}) {
      if (!entry.time && i < fields.size()) entry.time = TimeOf(fields[i]);
    }
    return entry;
  }

  // Empty if there is no such file. Windows writes folders with backslashes.
  std::string PathOf(const std::string& name) const {
    if (name.empty()) return "";
    for (const std::string& written : {name, absl::StrReplaceAll(name, {{"\\", "/"}})}) {
      for (const fs::path& folder : {folder_, folder_ / "data"}) {
        std::error_code error;
        const fs::path path = folder / written;
        if (!fs::is_regular_file(path, error)) continue;
        // Without ".." the pictures' names are relative to the folder that all share.
        const fs::path shortest = path.lexically_normal();
        return (fs::equivalent(shortest, path, error) ? shortest : path).string();
      }
    }
    return "";
  }

  const fs::path folder_;
  std::optional<size_t> time_column_;
};

absl::Status CheckAscending(const Line& line, double time, const std::vector<double>& before) {
  if (before.empty() || time > before.back()) return absl::OkStatus();
  if (time == before.back()) {
    return LineError(line,
                     absl::StrFormat("the time %.15g is equal to the one before it; give every "
                                     "picture its own time, or leave the times out",
                                     time));
  }
  return LineError(line,
                   absl::StrFormat("the time %.15g does not come after %.15g, which stands before "
                                   "it; sort the list by time",
                                   time, before.back()));
}

// By the median step, so that pauses do not matter.
absl::Status CheckUnit(const std::string& path, const std::vector<double>& times) {
  if (times.size() < 2) return absl::OkStatus();
  std::vector<double> steps;
  for (size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  const double median = MedianInPlace(steps);
  if (median < kLongestStepSeconds) return absl::OkStatus();
  const auto [unit, per_second] =
      median < 1e3 * kLongestStepSeconds   ? std::pair("milliseconds", 1e3)
      : median < 1e6 * kLongestStepSeconds ? std::pair("microseconds", 1e6)
                                           : std::pair("nanoseconds", 1e9);
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s: the times are read as seconds and step by %.15g, so they seem to be %s; divide them by "
      "%.0f, or leave them out",
      path, median, unit, per_second));
}

// None of a camera: a list like TUM's depth.txt.
bool AreSidePictures(const std::vector<std::string>& names) {
  return std::all_of(names.begin(), names.end(), [](const std::string& name) {
    return !SideKind(fs::path(name).parent_path().filename().string()).empty();
  });
}

}  // namespace

bool HasListExtension(const std::string& path) {
  const std::string extension = ExtensionOf(path);
  return extension == ".txt" || extension == ".csv";
}

absl::StatusOr<InputFiles> ReadFileList(const std::string& path) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<Line> lines, ReadLines(path));
  InputFiles list;
  ListReader reader(path);
  std::vector<std::string> names;
  size_t other_files = 0;
  for (const Line& line : lines) {
    if (&line == &lines.front() && reader.IsHeader(line.text)) continue;
    const Entry entry = reader.EntryOf(line.text);
    if (entry.path.empty()) {
      return LineError(
          line,
          entry.name.empty()   ? "neither a picture's name nor a time and a name; give one of them"
          : TimeOf(entry.name) ? "a time without a picture; give the folder of pictures, and this "
                                 "file to --times"
                               : absl::StrCat("no such file: ", entry.name,
                                              "; names are relative to the list's folder"));
    }
    names.push_back(entry.name);
    list.paths.push_back(entry.path);
    other_files += entry.other_files;
    if (list.paths.size() > 1 && entry.time.has_value() == list.times_seconds.empty()) {
      return LineError(line, "some lines have a time and some have none; give all or none");
    }
    if (entry.time) {
      EGOSIEVE_RETURN_IF_ERROR(CheckAscending(line, *entry.time, list.times_seconds));
      list.times_seconds.push_back(*entry.time);
    }
  }
  if (list.paths.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": the list names no picture; give a line for each"));
  }
  if (AreSidePictures(names)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, " lists ", SideKindOf(names.front()), " by the name of their folder, ",
                     names.front(), "; give the list of the camera's pictures, or rename it"));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckUnit(path, list.times_seconds));
  list.are_videos = HasVideoExtension(list.paths.front());
  if (other_files > 0) {
    list.remarks.push_back(absl::StrCat(other_files, " files in further columns of ", path,
                                        " are left out; the pictures are those like ",
                                        names.front()));
  }
  return list;
}

absl::StatusOr<std::vector<double>> ReadTimes(const std::string& path, size_t count) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<Line> lines, ReadLines(path));
  std::vector<double> times;
  for (const Line& line : lines) {
    const std::optional<double> time = TimeOf(line.text);
    if (!time) {
      return LineError(line, absl::StrCat("'", line.text,
                                          "' is no time; give seconds, nanoseconds or "
                                          "2011-09-26 13:02:25.59"));
    }
    EGOSIEVE_RETURN_IF_ERROR(CheckAscending(line, *time, times));
    times.push_back(*time);
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckUnit(path, times));
  if (times.size() == count) return times;
  return absl::InvalidArgumentError(absl::StrCat(path, " has ", times.size(), " times for ", count,
                                                 " pictures; give one for each"));
}

}  // namespace egosieve::vision
