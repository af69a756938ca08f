#include "tools/batch/manifest.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/toml_entries.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Flags = BatchSettings::Flags;

constexpr char kSegment[] = "segment";
constexpr char kDefaults[] = "defaults";

struct Drive {
  std::string name;   // of its table; empty in a list
  std::string where;  // "entry 2", for errors
  std::string path;
  BatchSettings settings;
  std::vector<int64_t> cuts;
};

struct Manifest {
  BatchSettings defaults;
  std::vector<Drive> drives;
};

std::vector<std::string> Words(const Flags& flags) {
  std::vector<std::string> words;
  for (const auto& [name, value] : flags) {
    words.push_back(value == "true" ? absl::StrCat("--", name)
                                    : absl::StrCat("--", name, "=", value));
  }
  return words;
}

BatchEntry Entry(const std::string& path, const std::string& out, const BatchSettings& settings) {
  const auto words = [&](const std::string& command) {
    const auto flags = settings.flags.find(command);
    return flags == settings.flags.end() ? std::vector<std::string>() : Words(flags->second);
  };
  BatchEntry entry{path, out, words(kSegment), {}};
  for (const std::string& command : settings.then) entry.then.push_back({command, words(command)});
  return entry;
}

// One value of a flag, as text.
std::optional<std::string> Text(const Json& value) {
  if (value.is_structured() || value.is_null()) return std::nullopt;
  return value.is_string() ? value.get<std::string>() : value.dump();
}

absl::Status FlagsFromJson(const std::string& where, const std::string& key, const Json& json,
                           Flags& flags) {
  if (!json.is_object()) {
    return Refused(where,
                   absl::StrCat("'", key, "' is not an object; write it as {\"stride\": 2}"));
  }
  for (const auto& [flag, given] : json.items()) {
    const std::optional<std::string> value = Text(given);
    if (!value) return Refused(where, absl::StrCat("the flag '", flag, "' has no single value"));
    EGOSIEVE_RETURN_IF_ERROR(AddFlag(where, flag, *value, flags));
  }
  return absl::OkStatus();
}

absl::Status SettingFromJson(const std::string& where, const std::string& key, const Json& value,
                             BatchSettings& settings) {
  if (key == "out") {
    if (!value.is_string()) return Refused(where, "'out' is not a text");
    settings.out = value.get<std::string>();
    return absl::OkStatus();
  }
  if (key == "then") {
    std::vector<std::string> words;
    for (const Json& word : value.is_array() ? value : Json::array({value})) {
      if (!word.is_string()) return Refused(where, "'then' is not a list of commands");
      words.push_back(word.get<std::string>());
    }
    return SetThen(where, words, settings);
  }
  if (key == "flags") return FlagsFromJson(where, key, value, settings.flags[kSegment]);
  if (IsFollowing(key)) return FlagsFromJson(where, key, value, settings.flags[key]);
  return Refused(where, absl::StrCat("unknown key '", key,
                                     "'; an entry has 'path', 'out', 'flags', 'then', 'cuts' and ",
                                     absl::StrJoin(FollowingCommands(), ", ")));
}

absl::StatusOr<std::vector<int64_t>> Cuts(const std::string& where,
                                          const std::vector<std::string>& words) {
  std::vector<int64_t> cuts;
  for (const std::string& word : words) {
    int64_t cut = 0;
    if (!absl::SimpleAtoi(word, &cut) || cut <= (cuts.empty() ? 0 : cuts.back())) {
      return Refused(where, "'cuts' is not an ascending list of frame numbers above 0");
    }
    cuts.push_back(cut);
  }
  return cuts;
}

absl::StatusOr<Drive> DriveFromJson(const std::string& where, const Json& json) {
  if (!json.is_object()) {
    return Refused(
        where, absl::StrCat(json.dump().substr(0, 60), " is not an object with 'path' and 'out'"));
  }
  Drive drive;
  drive.where = where;
  for (const auto& [key, value] : json.items()) {
    if (key == "cuts") {
      std::vector<std::string> words;
      for (const Json& cut : value.is_array() ? value : Json::array({value})) {
        words.push_back(cut.dump());
      }
      EGOSIEVE_ASSIGN_OR_RETURN(drive.cuts, Cuts(where, words));
    } else if (key != "path") {
      EGOSIEVE_RETURN_IF_ERROR(SettingFromJson(where, key, value, drive.settings));
    } else if (!value.is_string()) {
      return Refused(where, "'path' is not a text");
    } else {
      drive.path = value.get<std::string>();
    }
  }
  return drive;
}

absl::StatusOr<Manifest> ParseJson(absl::string_view text) {
  Json json;
  try {
    json = Json::parse(text.begin(), text.end());
  } catch (const Json::exception& error) {  // also for numbers beyond the range of a double
    return absl::InvalidArgumentError(absl::StrCat("it is not JSON: ", error.what()));
  }
  Manifest manifest;
  if (json.is_object() && json.contains("drives")) {
    for (const auto& [key, value] : json.items()) {
      if (key == "drives") continue;
      if (key != kDefaults || !value.is_object()) {
        return absl::InvalidArgumentError(
            absl::StrCat("'", key, "' is neither 'drives' nor an object of 'defaults'"));
      }
      for (const auto& [name, given] : value.items()) {
        EGOSIEVE_RETURN_IF_ERROR(SettingFromJson(kDefaults, name, given, manifest.defaults));
      }
    }
    json = Json(json["drives"]);
  }
  if (!json.is_array()) {
    return absl::InvalidArgumentError("it is not a list of drives; write it as [{...}, {...}]");
  }
  for (const Json& element : json) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        Drive drive, DriveFromJson(absl::StrCat("entry ", manifest.drives.size() + 1), element));
    manifest.drives.push_back(std::move(drive));
  }
  return manifest;
}

// `keys`: the entries of the table.
absl::Status SettingFromToml(const std::string& where, const std::vector<std::string>& keys,
                             const TomlEntry& entry, BatchSettings& settings) {
  const std::string& key = keys.front();
  if (keys.size() == 1 && key == "then") return SetThen(where, entry.values, settings);
  if (entry.is_array)
    return Refused(where, absl::StrCat("'", keys.back(), "' has no single value"));
  const std::string& value = entry.values.front();
  if (keys.size() == 2 && IsFollowing(key)) {
    return AddFlag(where, keys.back(), value, settings.flags[key]);
  }
  if (keys.size() != 1) {
    return Refused(where, absl::StrCat("'", key, "' has flags, and is none of ",
                                       absl::StrJoin(FollowingCommands(), ", ")));
  }
  if (key == "out") {
    settings.out = value;
    return absl::OkStatus();
  }
  return AddFlag(where, key, value, settings.flags[kSegment]);
}

absl::StatusOr<Manifest> ParseToml(absl::string_view text) {
  auto entries = ReadTomlEntries(text);
  if (!entries.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("it is neither JSON nor TOML: ", entries.status().message()));
  }
  Manifest manifest;
  std::map<std::string, size_t> numbers;  // of the tables, from 1
  for (const TomlEntry& entry : *entries) {
    std::string table = entry.path.front();
    size_t depth = 1;
    const bool is_listed = table == "drives" && entry.path.size() > 2 && entry.path[1] != "path";
    if (is_listed) table = absl::StrCat(table, "/", entry.path[depth++]);
    const std::vector<std::string> keys(entry.path.begin() + static_cast<int64_t>(depth),
                                        entry.path.end());
    if (keys.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", entry.line, ": '", table,
                       "' is outside the tables of the drives; write [name] above"));
    }
    if (table == kDefaults) {
      EGOSIEVE_RETURN_IF_ERROR(SettingFromToml(kDefaults, keys, entry, manifest.defaults));
      continue;
    }
    size_t& number = numbers[table];
    if (number == 0) {
      Drive drive;
      drive.name = is_listed ? "" : table;
      number = manifest.drives.size() + 1;
      drive.where = absl::StrCat("entry ", number);
      manifest.drives.push_back(std::move(drive));
    }
    Drive& drive = manifest.drives[number - 1];
    if (keys.size() == 1 && keys.front() == "path" && !entry.is_array) {
      drive.path = entry.values.front();
    } else if (keys.size() == 1 && keys.front() == "cuts") {
      EGOSIEVE_ASSIGN_OR_RETURN(drive.cuts, Cuts(drive.where, entry.values));
    } else {
      EGOSIEVE_RETURN_IF_ERROR(SettingFromToml(drive.where, keys, entry, drive.settings));
    }
  }
  return manifest;
}

// "runs/a/" and "runs/a" are the same folder.
std::string From(const std::string& folder, const std::string& path) {
  const fs::path normal = (fs::path(folder) / path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).string();
}

bool IsJson(absl::string_view text) {
  const absl::string_view start = absl::StripLeadingAsciiWhitespace(text);
  // "[{" and "[]" begin a list, "[name]" a table.
  const absl::string_view second =
      absl::StripLeadingAsciiWhitespace(start.substr(std::min<size_t>(1, start.size())));
  return absl::StartsWith(start, "{") ||
         (absl::StartsWith(start, "[") &&
          (second.empty() || second[0] == '{' || second[0] == ']' || second[0] == '"'));
}

// The run folder of a drive: its own, else that of `given`, else that of the defaults; empty if
// none is set.
std::string OutOf(const Drive& drive, const std::string& folder, const BatchSettings& given,
                  const BatchSettings& defaults) {
  if (!drive.settings.out.empty()) return From(folder, drive.settings.out);
  const std::string name =
      drive.name.empty() ? fs::path(From("", drive.path)).stem().string() : drive.name;
  if (!given.out.empty()) return From(given.out, name);
  return defaults.out.empty() ? "" : From(folder, (fs::path(defaults.out) / name).string());
}

}  // namespace

BatchEntry MakeEntry(const std::string& name, const std::string& path, const BatchSettings& given) {
  return Entry(path, From(given.out, name), given);
}

absl::StatusOr<std::vector<BatchEntry>> ParseManifest(absl::string_view text,
                                                      const std::string& folder,
                                                      const BatchSettings& given) {
  EGOSIEVE_ASSIGN_OR_RETURN(const Manifest manifest,
                            IsJson(text) ? ParseJson(text) : ParseToml(text));
  if (manifest.drives.empty()) return absl::InvalidArgumentError("it lists no drive");
  std::vector<BatchEntry> entries;
  for (const Drive& drive : manifest.drives) {
    if (drive.path.empty()) return Refused(drive.where, "no 'path', the drive's input");
    const std::string out = OutOf(drive, folder, given, manifest.defaults);
    if (out.empty()) return Refused(drive.where, "no 'out', the run folder to write");
    BatchSettings settings = manifest.defaults;
    Override(drive.settings, settings);
    Override(given, settings);
    entries.push_back(Entry(From(folder, drive.path), out, settings));
    entries.back().cuts = drive.cuts;
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckFolders(entries));
  return entries;
}

absl::Status CheckFolders(const std::vector<BatchEntry>& entries) {
  std::map<std::string, size_t> folders;
  for (size_t i = 0; i < entries.size(); ++i) {
    if (const auto [other, is_new] = folders.emplace(entries[i].out, i + 1); !is_new) {
      return Refused(absl::StrCat("entry ", i + 1),
                     absl::StrCat("its 'out', ", entries[i].out, ", is that of entry ",
                                  other->second, ", ", entries[other->second - 1].path));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<BatchEntry>> ReadManifest(const std::string& path,
                                                     const BatchSettings& given) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  absl::StatusOr<std::vector<BatchEntry>> entries =
      ParseManifest(text, fs::path(path).parent_path().string(), given);
  if (entries.ok()) return entries;
  return absl::Status(
      entries.status().code(),
      absl::StrCat("the manifest ", path, " cannot be used: ", entries.status().message()));
}

}  // namespace egosieve::tools
