#include "tools/batch/manifest.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Flags that belong to the batch itself.
constexpr const char* kReserved[] = {"out", "resume", "overwrite", "config", "print_config"};

template <typename... Args>
absl::Status Refused(size_t number, const absl::FormatSpec<Args...>& format, const Args&... args) {
  return absl::InvalidArgumentError(
      absl::StrCat("entry ", number, ": ", absl::StrFormat(format, args...)));
}

absl::Status AddFlag(size_t number, const std::string& name, const std::string& value,
                     BatchEntry& entry) {
  for (const char* reserved : kReserved) {
    if (name == reserved) {
      return Refused(number, "the flag '%s' is the batch's own; leave it out", name);
    }
  }
  if (value == "false") return absl::OkStatus();
  entry.flags.push_back(value == "true" ? absl::StrCat("--", name)
                                        : absl::StrCat("--", name, "=", value));
  return absl::OkStatus();
}

absl::StatusOr<BatchEntry> FromJson(size_t number, const Json& json) {
  if (!json.is_object()) {
    return Refused(number, "%s is not an object with 'path' and 'out'", json.dump().substr(0, 60));
  }
  BatchEntry entry;
  for (const auto& [key, value] : json.items()) {
    if (key == "path" || key == "out") {
      if (!value.is_string()) return Refused(number, "'%s' is not a text", key);
      (key == "path" ? entry.path : entry.out) = value.get<std::string>();
    } else if (key != "flags") {
      return Refused(number, "unknown key '%s'; an entry has 'path', 'out' and 'flags'", key);
    } else if (!value.is_object()) {
      return Refused(number, "'flags' is not an object; write it as {\"stride\": 2}");
    } else {
      for (const auto& [flag, given] : value.items()) {
        if (given.is_structured() || given.is_null()) {
          return Refused(number, "the flag '%s' has no single value", flag);
        }
        EGOSIEVE_RETURN_IF_ERROR(AddFlag(
            number, flag, given.is_string() ? given.get<std::string>() : given.dump(), entry));
      }
    }
  }
  return entry;
}

absl::StatusOr<std::vector<BatchEntry>> ParseJson(absl::string_view text) {
  Json json;
  try {
    json = Json::parse(text.begin(), text.end());
  } catch (const Json::parse_error& error) {
    return absl::InvalidArgumentError(absl::StrCat("it is not JSON: ", error.what()));
  }
  if (!json.is_array()) {
    return absl::InvalidArgumentError("it is not a list of drives; write it as [{...}, {...}]");
  }
  std::vector<BatchEntry> entries;
  for (const Json& element : json) {
    EGOSIEVE_ASSIGN_OR_RETURN(BatchEntry entry, FromJson(entries.size() + 1, element));
    entries.push_back(std::move(entry));
  }
  return entries;
}

absl::StatusOr<std::vector<BatchEntry>> ParseToml(absl::string_view text) {
  std::vector<CLI::ConfigItem> items;
  try {
    std::istringstream stream{std::string(text)};
    items = CLI::ConfigTOML().from_config(stream);
  } catch (const CLI::Error& error) {
    return absl::InvalidArgumentError(absl::StrCat("it is neither JSON nor TOML: ", error.what()));
  }
  std::vector<BatchEntry> entries;
  std::map<std::string, size_t> numbers;  // of the tables, from 1
  for (const CLI::ConfigItem& item : items) {
    if (item.name == "++" || item.name == "--") continue;  // a table begins or ends
    if (item.parents.size() != 1) {
      return absl::InvalidArgumentError(absl::StrCat(
          "'", item.fullname(), "' stands outside the tables of the drives; write [name] above"));
    }
    size_t& number = numbers[item.parents.front()];
    if (number == 0) {
      entries.emplace_back();
      number = entries.size();
    }
    if (item.inputs.size() != 1) {
      return Refused(number, "'%s' has no single value", item.name);
    }
    BatchEntry& entry = entries[number - 1];
    const std::string& value = item.inputs.front();
    if (item.name == "path" || item.name == "out") {
      (item.name == "path" ? entry.path : entry.out) = value;
    } else {
      EGOSIEVE_RETURN_IF_ERROR(AddFlag(number, item.name, value, entry));
    }
  }
  return entries;
}

// "runs/a/" and "runs/a" are one folder.
std::string From(const std::string& folder, const std::string& path) {
  const fs::path normal = (fs::path(folder) / path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).string();
}

}  // namespace

absl::StatusOr<std::vector<BatchEntry>> ParseManifest(absl::string_view text,
                                                      const std::string& folder) {
  const absl::string_view start = absl::StripLeadingAsciiWhitespace(text);
  // "[{" and "[]" begin a list, "[name]" a table.
  const absl::string_view second =
      absl::StripLeadingAsciiWhitespace(start.substr(std::min<size_t>(1, start.size())));
  const bool is_json = absl::StartsWith(start, "{") ||
                       (absl::StartsWith(start, "[") && (second.empty() || second[0] == '{' ||
                                                         second[0] == ']' || second[0] == '"'));
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<BatchEntry> entries,
                            is_json ? ParseJson(text) : ParseToml(text));
  if (entries.empty()) {
    return absl::InvalidArgumentError("it lists no drive");
  }
  std::map<std::string, size_t> folders;
  for (size_t i = 0; i < entries.size(); ++i) {
    BatchEntry& entry = entries[i];
    if (entry.path.empty()) return Refused(i + 1, "no 'path', the drive's input");
    if (entry.out.empty()) return Refused(i + 1, "no 'out', the run folder to write");
    entry.path = From(folder, entry.path);
    entry.out = From(folder, entry.out);
    if (const auto [other, is_new] = folders.emplace(entry.out, i + 1); !is_new) {
      return Refused(i + 1, "its 'out', %s, is that of entry %d", entry.out, other->second);
    }
  }
  return entries;
}

absl::StatusOr<std::vector<BatchEntry>> ReadManifest(const std::string& path) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  absl::StatusOr<std::vector<BatchEntry>> entries =
      ParseManifest(text, fs::path(path).parent_path().string());
  if (entries.ok()) return entries;
  return absl::Status(
      entries.status().code(),
      absl::StrCat("the manifest ", path, " cannot be used: ", entries.status().message()));
}

}  // namespace egosieve::tools
