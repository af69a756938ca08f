#include "tools/batch/manifest.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/command.h"
#include "tools/cli/toml_entries.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Flags that only the batch itself sets.
constexpr const char* kReserved[] = {"out", "resume", "overwrite", "config", "print_config"};

bool IsFollowing(const std::string& word) {
  const std::vector<std::string>& all = FollowingCommands();
  return std::find(all.begin(), all.end(), word) != all.end();
}

// `where`: empty, or the entry.
absl::Status Refused(const std::string& where, const std::string& what) {
  return absl::InvalidArgumentError(where.empty() ? what : absl::StrCat(where, ": ", what));
}

// One value, as text.
std::optional<std::string> Text(const Json& value) {
  if (value.is_structured() || value.is_null()) return std::nullopt;
  return value.is_string() ? value.get<std::string>() : value.dump();
}

// Adds flags, an object, to `settings` under `key`, each as text.
absl::Status AddFlags(const std::string& where, const Json& flags, const std::string& key,
                      Json& settings) {
  if (!flags.is_object()) {
    return Refused(where,
                   absl::StrCat("'", key, "' is not an object; write it as {\"stride\": 2}"));
  }
  for (const auto& [name, value] : flags.items()) {
    const std::optional<std::string> text = Text(value);
    if (std::count(std::begin(kReserved), std::end(kReserved), name) > 0) {
      return Refused(where, absl::StrCat("the flag '", name, "' is the batch's own; leave it out"));
    }
    if (!text) return Refused(where, absl::StrCat("the flag '", name, "' has no single value"));
    settings[key][name] = *text;
  }
  return absl::OkStatus();
}

// "--stride=2", "--deterministic" as an object.
absl::StatusOr<Json> ParseFlags(const std::vector<std::string>& words) {
  Json flags = Json::object();
  for (absl::string_view word : words) {
    if (!absl::ConsumePrefix(&word, "--")) {
      return absl::InvalidArgumentError(
          absl::StrCat("'", word, "' is no flag; write flags as --name=value"));
    }
    // "set=NAME" is a name, too.
    const size_t end = word.find('=', absl::StartsWith(word, "set=") ? 4 : 0);
    flags[std::string(word.substr(0, end))] =
        end == word.npos ? "true" : std::string(word.substr(end + 1));
  }
  return flags;
}

std::vector<std::string> Words(const Json& settings, const std::string& key) {
  std::vector<std::string> words;
  const Json flags = settings.value(key, Json::object());
  for (const auto& [name, value] : flags.items()) {
    const std::string text = value.get<std::string>();
    words.push_back(text == "true" ? absl::StrCat("--", name)
                                   : absl::StrCat("--", name, "=", text));
  }
  return words;
}

Json AsList(const Json& value) { return value.is_array() ? value : Json::array({value}); }

absl::Status SetThen(const std::string& where, const Json& value, Json& settings) {
  settings["then"] = Json::array();
  for (const Json& word : AsList(value)) {
    const std::string command = PresentName(Text(word).value_or("{}"));
    if (!IsFollowing(command)) {
      return Refused(where, absl::StrCat("then: '", command, "' is none of ",
                                         absl::StrJoin(FollowingCommands(), ", ")));
    }
    settings["then"].push_back(command);
  }
  return absl::OkStatus();
}

absl::Status SetCuts(const std::string& where, const Json& value, Json& settings) {
  settings["cuts"] = Json::array();
  int64_t before = 0, cut = 0;
  for (const Json& frame : AsList(value)) {
    if (!absl::SimpleAtoi(Text(frame).value_or(""), &cut) || cut <= before) {
      return Refused(where, "'cuts' is not an ascending list of frame numbers above 0");
    }
    settings["cuts"].push_back(before = cut);
  }
  return absl::OkStatus();
}

// What a table sets: path, out, then, cuts, and flags as text, those of segment in "flags".
absl::StatusOr<Json> SettingsIn(const std::string& where, const Json& table) {
  if (!table.is_object()) {
    return Refused(
        where, absl::StrCat(table.dump().substr(0, 60), " is not an object with 'path' and 'out'"));
  }
  Json settings = Json::object();
  for (const auto& [given_key, value] : table.items()) {
    const std::string key = PresentName(given_key);
    absl::Status status;
    if (key == "path" || key == "out") {
      if (!value.is_string()) return Refused(where, absl::StrCat("'", key, "' is not a text"));
      settings[key] = value;
    } else if (key == "then") {
      status = SetThen(where, value, settings);
    } else if (key == "cuts") {
      status = SetCuts(where, value, settings);
    } else if (key == "research" && value.is_object()) {
      Json flags = Json::object();
      for (const auto& [name, setting] : value.items()) flags[absl::StrCat("set=", name)] = setting;
      status = AddFlags(where, flags, "flags", settings);
    } else if (key == "flags" || IsFollowing(key)) {
      status = AddFlags(where, value, key, settings);
    } else if (value.is_object()) {
      status = Refused(where, absl::StrCat("'", key, "' has flags, and is none of ",
                                           absl::StrJoin(FollowingCommands(), ", ")));
    } else {
      status = AddFlags(where, Json::object({{key, value}}), "flags", settings);
    }
    EGOSIEVE_RETURN_IF_ERROR(status);
  }
  return settings;
}

absl::StatusOr<Json> GivenSettings(const BatchSettings& given) {
  Json table = Json::object();
  if (given.then) {
    const std::vector<std::string> words =
        absl::StrSplit(*given.then, absl::ByAnyChar(", "), absl::SkipEmpty());
    table["then"] = *given.then == "none" ? std::vector<std::string>() : words;
  }
  for (const auto& [key, text] :
       {std::pair{"flags", given.segment_flags}, {"masks", given.masks_flags}}) {
    EGOSIEVE_ASSIGN_OR_RETURN(table[key], ParseFlags(absl::StrSplit(text, ' ', absl::SkipEmpty())));
  }
  return SettingsIn("", table);
}

BatchEntry Entry(const std::string& path, const std::string& out, const Json& settings) {
  BatchEntry entry = {path, out, Words(settings, "flags"), {}, {}};
  for (const Json& command : settings.value("then", Json({"refine", "report"}))) {
    entry.then.push_back({command, Words(settings, command)});
  }
  entry.cuts = settings.value("cuts", std::vector<int64_t>());
  return entry;
}

absl::StatusOr<Json> ParseDocument(absl::string_view text) {
  std::string not_json;
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::exception& error) {  // also for numbers beyond the range of a double
    not_json = error.what();
  }
  const auto entries = ReadTomlEntries(text);
  if (!entries.ok()) {
    return absl::InvalidArgumentError(absl::StrCat("it is neither JSON (", not_json, ") nor TOML (",
                                                   entries.status().message(), ")"));
  }
  Json document = Json::object();
  for (const TomlEntry& entry : *entries) {
    Json* place = &document;
    for (const std::string& name : entry.path) place = &(*place)[name];
    *place = entry.is_array ? Json(entry.values) : Json(entry.values.front());
  }
  return document;
}

// The tables of the drives with their names, empty in a list; takes out `defaults`.
absl::StatusOr<std::vector<std::pair<std::string, Json>>> Tables(const Json& document,
                                                                 Json& defaults) {
  std::vector<std::pair<std::string, Json>> tables;
  const auto add_list = [&](const Json& list) {
    for (const auto& item : list.items()) tables.emplace_back("", item.value());
  };
  if (document.is_array()) add_list(document);
  if (!document.is_object()) return tables;
  for (const auto& [name, value] : document.items()) {
    if (name == "drives" && value.is_structured() && !value.contains("path")) {
      add_list(value);
    } else if (!value.is_object()) {
      return Refused("", absl::StrCat("'", name,
                                      "' is outside the tables of the drives; write "
                                      "[name] above, or a list"));
    } else if (name == "defaults") {
      EGOSIEVE_ASSIGN_OR_RETURN(defaults, SettingsIn(name, value));
    } else {
      tables.emplace_back(name, value);
    }
  }
  return tables;
}

// "runs/a/" and "runs/a" are the same folder.
std::string From(const fs::path& folder, const fs::path& path) {
  const fs::path normal = (folder / path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).string();
}

}  // namespace

const std::vector<std::string>& FollowingCommands() {
  static const auto& commands =
      *new std::vector<std::string>{"refine", "masks", "render", "report"};
  return commands;
}

absl::StatusOr<BatchEntry> MakeEntry(const std::string& name, const std::string& path,
                                     const BatchSettings& given) {
  EGOSIEVE_ASSIGN_OR_RETURN(const Json settings, GivenSettings(given));
  return Entry(path, From(given.out, name), settings);
}

absl::StatusOr<std::vector<BatchEntry>> ParseManifest(absl::string_view text,
                                                      const std::string& folder,
                                                      const BatchSettings& given) {
  EGOSIEVE_ASSIGN_OR_RETURN(const Json overriding, GivenSettings(given));
  EGOSIEVE_ASSIGN_OR_RETURN(const Json document, ParseDocument(text));
  Json defaults = Json::object();
  EGOSIEVE_ASSIGN_OR_RETURN(const auto tables, Tables(document, defaults));
  if (tables.empty()) return absl::InvalidArgumentError("it lists no drive");
  const std::string shared = defaults.value("out", "");
  defaults.erase("out");
  std::vector<BatchEntry> entries;
  for (const auto& [name, table] : tables) {
    const std::string where = absl::StrCat("entry ", entries.size() + 1);
    EGOSIEVE_ASSIGN_OR_RETURN(const Json own, SettingsIn(where, table));
    Json settings = defaults;
    settings.merge_patch(own);
    settings.merge_patch(overriding);
    const std::string path = settings.value("path", ""), out = settings.value("out", "");
    if (path.empty()) return Refused(where, "no 'path', the drive's input");
    const std::string called = name.empty() ? fs::path(From("", path)).stem().string() : name;
    const std::string run = !out.empty()         ? From(folder, out)
                            : !given.out.empty() ? From(given.out, called)
                            : !shared.empty()    ? From(folder, fs::path(shared) / called)
                                                 : "";
    if (run.empty()) return Refused(where, "no 'out', the run folder to write");
    entries.push_back(Entry(From(folder, path), run, settings));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckFolders(entries));
  return entries;
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

std::string ToManifest(const std::vector<BatchEntry>& entries) {
  Json drives = Json::array();
  for (const BatchEntry& entry : entries) {
    Json drive = {{"path", AbsolutePath(entry.path)},
                  {"out", AbsolutePath(entry.out)},
                  {"flags", ParseFlags(entry.flags).value_or(Json::object())},
                  {"then", Json::array()},
                  {"cuts", entry.cuts}};
    for (const BatchStep& step : entry.then) {
      drive["then"].push_back(step.command);
      drive[step.command] = ParseFlags(step.flags).value_or(Json::object());
    }
    drives.push_back(std::move(drive));
  }
  return drives.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
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

}  // namespace egosieve::tools
