#include "vision/frame/file_list.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/time/time.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMaximumBytes = int64_t{1} << 30;
constexpr size_t kNanosecondDigits = 18;

struct Line {
  size_t number = 0;  // from 1
  std::string text;
};

absl::StatusOr<std::vector<Line>> ReadLines(const std::string& path) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, kernels::ReadFile(path, kMaximumBytes));
  std::vector<Line> lines;
  size_t number = 0;
  for (const absl::string_view row : absl::StrSplit(text, '\n')) {
    ++number;
    const absl::string_view content = absl::StripAsciiWhitespace(row);
    if (!content.empty() && content.front() != '#') lines.push_back({number, std::string(content)});
  }
  return lines;
}

absl::Status LineError(const std::string& path, const Line& line, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat(path, ", line ", line.number, ": ", what));
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

struct Entry {
  std::string name;
  std::optional<double> time;
};

// Nothing for a line of column names.
std::optional<Entry> EntryOf(const std::string& text) {
  if (text.find(',') != std::string::npos) {
    std::vector<std::string> fields = absl::StrSplit(text, ',');
    for (std::string& field : fields) absl::StripAsciiWhitespace(&field);
    if (const auto time = TimeOf(fields[0])) return Entry{fields[1], time};
    if (const auto time = TimeOf(fields[1])) return Entry{fields[0], time};
    return std::nullopt;
  }
  const size_t end = text.find_first_of(" \t");
  if (end != std::string::npos) {
    if (const auto time = TimeOf(absl::string_view(text).substr(0, end))) {
      return Entry{std::string(absl::StripAsciiWhitespace(text.substr(end))), time};
    }
  }
  return Entry{text, std::nullopt};
}

absl::Status CheckAscending(const std::string& path, const Line& line, double time,
                            const std::vector<double>& before) {
  if (before.empty() || time > before.back()) return absl::OkStatus();
  return LineError(path, line,
                   absl::StrFormat("the time %.9g does not come after %.9g, which stands before "
                                   "it; sort the list by time",
                                   time, before.back()));
}

// The folder that the list's names are relative to.
fs::path FolderOf(const fs::path& list, const std::string& name) {
  std::error_code error;
  const fs::path folder = list.parent_path();
  return !fs::exists(folder / name, error) && fs::exists(folder / "data" / name, error)
             ? folder / "data"
             : folder;
}

}  // namespace

bool HasListExtension(const std::string& path) {
  const std::string extension = absl::AsciiStrToLower(fs::path(path).extension().string());
  return extension == ".txt" || extension == ".csv";
}

absl::StatusOr<FileList> ReadFileList(const std::string& path) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<Line> lines, ReadLines(path));
  FileList list;
  fs::path folder;
  for (const Line& line : lines) {
    const std::optional<Entry> entry = EntryOf(line.text);
    if (!entry) {
      if (&line == &lines.front()) continue;
      return LineError(path, line,
                       "neither a picture's name nor a time and a name; give one of them");
    }
    if (list.paths.empty()) folder = FolderOf(path, entry->name);
    list.paths.push_back((folder / entry->name).string());
    std::error_code error;
    if (!fs::is_regular_file(list.paths.back(), error)) {
      const bool is_time = !entry->time && TimeOf(entry->name);
      return LineError(path, line,
                       is_time ? "a time without a picture; give the folder of pictures, and this "
                                 "file to --times"
                               : absl::StrCat("no such file: ", list.paths.back(),
                                              "; names are relative to the list's folder"));
    }
    if (list.paths.size() > 1 && entry->time.has_value() == list.times_seconds.empty()) {
      return LineError(path, line, "some lines have a time and some have none; give all or none");
    }
    if (entry->time) {
      EGOSIEVE_RETURN_IF_ERROR(CheckAscending(path, line, *entry->time, list.times_seconds));
      list.times_seconds.push_back(*entry->time);
    }
  }
  if (!list.paths.empty()) return list;
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": the list names no picture; give a line for each"));
}

absl::StatusOr<std::vector<double>> ReadTimes(const std::string& path, size_t count) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<Line> lines, ReadLines(path));
  std::vector<double> times;
  for (const Line& line : lines) {
    const std::optional<double> time = TimeOf(line.text);
    if (!time) {
      return LineError(path, line,
                       absl::StrCat("'", line.text,
                                    "' is no time; give seconds, nanoseconds or "
                                    "2011-09-26 13:02:25.59"));
    }
    EGOSIEVE_RETURN_IF_ERROR(CheckAscending(path, line, *time, times));
    times.push_back(*time);
  }
  if (times.size() == count) return times;
  return absl::InvalidArgumentError(absl::StrCat(path, " has ", times.size(), " times for ", count,
                                                 " pictures; give one for each"));
}

}  // namespace egosieve::vision
