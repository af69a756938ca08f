#include "tools/batch/drives.h"

#include <glob.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "absl/types/span.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/command.h"
#include "tools/cli/toml_entries.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/drive_input.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/input_files.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Flags = std::vector<std::pair<std::string, std::string>>;  // names and values

constexpr char kSegment[] = "segment";

absl::Status CheckFollowing(const std::string& word) {
  const std::vector<std::string>& all = FollowingCommands();
  if (std::find(all.begin(), all.end(), word) != all.end()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("'", word, "' is none of ", absl::StrJoin(all, ", ")));
}

// What is said of a drive; what is set later overrides.
struct Settings {
  std::string path, out;
  std::vector<std::string> then = {"refine", "report"};
  std::vector<int64_t> cuts;
  std::map<std::string, Flags> flags;  // by command

  void SetFlag(const std::string& command, const std::string& name, const std::string& value) {
    Flags& own = flags[command];
    const auto same =
        std::find_if(own.begin(), own.end(), [&](const auto& flag) { return flag.first == name; });
    if (same != own.end()) own.erase(same);
    own.emplace_back(name, value);
  }
  absl::Status SetThen(const std::vector<std::string>& words);
  absl::Status SetCuts(const std::vector<std::string>& frames);
  // keys: within the drive's table.
  absl::Status Set(absl::Span<const std::string> keys, const TomlEntry& entry);
  absl::Status SetGiven(const BatchSettings& given);

  std::vector<std::string> Words(const std::string& command) const;
};

absl::Status Settings::SetThen(const std::vector<std::string>& words) {
  then.clear();
  for (const std::string& word : words) {
    then.push_back(PresentName(word));
    EGOSIEVE_RETURN_IF_ERROR(CheckFollowing(then.back()));
  }
  return absl::OkStatus();
}

absl::Status Settings::SetCuts(const std::vector<std::string>& frames) {
  cuts = {0};
  for (const std::string& frame : frames) {
    cuts.push_back(0);
    if (!absl::SimpleAtoi(frame, &cuts.back()) || cuts.back() <= cuts[cuts.size() - 2]) {
      return absl::InvalidArgumentError("'cuts' is not an ascending list of frame numbers above 0");
    }
  }
  cuts.erase(cuts.begin());
  return absl::OkStatus();
}

absl::Status Settings::Set(absl::Span<const std::string> keys, const TomlEntry& entry) {
  const std::string& key = keys.back();
  const bool is_own = keys.size() == 1;
  if (is_own && key == "then") return SetThen(entry.values);
  if (is_own && key == "cuts") return SetCuts(entry.values);
  if (entry.is_array || keys.size() > 2) {
    return absl::InvalidArgumentError(absl::StrCat("'", key, "' has no single value"));
  }
  const std::string& value = entry.values.front();
  if (is_own && (key == "path" || key == "out")) {
    (key == "path" ? path : out) = value;
  } else if (is_own) {
    SetFlag(kSegment, key, value);
  } else if (keys.front() == "research") {
    SetFlag(kSegment, "set=" + key, value);
  } else {
    const std::string command = PresentName(keys.front());
    EGOSIEVE_RETURN_IF_ERROR(CheckFollowing(command));
    SetFlag(command, key, value);
  }
  return absl::OkStatus();
}

absl::Status Settings::SetGiven(const BatchSettings& given) {
  if (given.then) {
    EGOSIEVE_RETURN_IF_ERROR(
        SetThen(*given.then == "none"
                    ? std::vector<std::string>()
                    : absl::StrSplit(*given.then, absl::ByAnyChar(", "), absl::SkipEmpty())));
  }
  for (const auto& [command, text] :
       {std::pair{kSegment, given.segment_flags}, {"masks", given.masks_flags}}) {
    for (absl::string_view word : absl::StrSplit(text, ' ', absl::SkipEmpty())) {
      if (!absl::ConsumePrefix(&word, "--")) {
        return absl::InvalidArgumentError(
            absl::StrCat("'", word, "' is no flag; write flags as --name=value"));
      }
      // "set=NAME" is a name, too.
      const size_t end = word.find('=', absl::StartsWith(word, "set=") ? 4 : 0);
      SetFlag(command, std::string(word.substr(0, end)),
              end == word.npos ? "true" : std::string(word.substr(end + 1)));
    }
  }
  return absl::OkStatus();
}

std::vector<std::string> Settings::Words(const std::string& command) const {
  std::vector<std::string> words;
  if (flags.count(command) == 0) return words;
  for (const auto& [name, value] : flags.at(command)) {
    words.push_back(value == "true" ? "--" + name : absl::StrCat("--", name, "=", value));
  }
  return words;
}

// "runs/a/" and "runs/a" are the same folder.
std::string From(const fs::path& folder, const fs::path& path) {
  const fs::path normal = (folder / path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).string();
}

// folder: where paths begin. shared: the folder for run folders that nothing else names.
absl::StatusOr<BatchEntry> MakeEntry(const std::string& name, Settings settings,
                                     const std::string& folder, const std::string& shared,
                                     const BatchSettings& given) {
  EGOSIEVE_RETURN_IF_ERROR(settings.SetGiven(given));
  if (settings.path.empty()) return absl::InvalidArgumentError("no 'path', the drive's input");
  const std::string run = !settings.out.empty() ? From(folder, settings.out)
                          : !given.out.empty()  ? From(given.out, name)
                          : !shared.empty()     ? From(folder, fs::path(shared) / name)
                                                : "";
  if (run.empty()) return absl::InvalidArgumentError("no 'out', the run folder to write");
  BatchEntry entry = {
      From(folder, settings.path), run, settings.Words(kSegment), {}, settings.cuts};
  for (const std::string& command : settings.then) {
    entry.then.push_back({command, settings.Words(command)});
  }
  return entry;
}

bool Holds(const fs::path& folder, bool (*is_kind)(const std::string&)) {
  std::error_code error;
  const fs::directory_iterator children(folder, error);
  return std::any_of(begin(children), end(children),
                     [&](const auto& child) { return is_kind(child.path().string()); });
}

// The path for segment; empty if the path is not a drive.
std::string InputOf(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    return vision::HasVideoExtension(path.string()) ? path.string() : "";
  }
  for (const fs::path& folder : {path, path / "frames", path / "images"}) {
    if (Holds(folder, vision::HasImageExtension) || Holds(folder, vision::HasVideoExtension)) {
      return folder.string();
    }
  }
  return "";
}

std::vector<fs::path> PathsIn(const fs::path& folder) {
  std::error_code error;
  const fs::directory_iterator children(folder, error);
  return {begin(children), end(children)};
}

std::vector<fs::path> Matches(const std::string& pattern) {
  glob_t found = {};
  std::vector<fs::path> matches;
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0) {
    matches.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  }
  globfree(&found);
  return matches;
}

// The drives in a folder or of a glob, in natural order.
absl::StatusOr<std::vector<fs::path>> FindDrives(const std::string& input) {
  std::error_code error;
  std::vector<fs::path> paths = fs::is_directory(input, error) ? PathsIn(input)
                                : fs::exists(input, error)     ? std::vector<fs::path>{input}
                                                               : Matches(input);
  if (paths.empty() && !fs::exists(input, error)) {
    return absl::NotFoundError(
        absl::StrCat("there is no ", input, ", and no file matches it; quote a pattern"));
  }
  std::erase_if(paths, [](const auto& path) { return path.filename().string().starts_with('.'); });
  std::sort(paths.begin(), paths.end(), [](const fs::path& a, const fs::path& b) {
    return vision::NaturalLess(a.string(), b.string());
  });
  const auto others = std::stable_partition(
      paths.begin(), paths.end(), [](const fs::path& path) { return !InputOf(path).empty(); });
  if (others == paths.begin()) {
    return absl::InvalidArgumentError(
        fs::is_directory(input, error) && Holds(input, vision::HasImageExtension)
            ? absl::StrCat(input,
                           " holds the pictures of one drive; give it to segment, or name the "
                           "folder above it")
            : absl::StrCat(input, " has no drive: no video, and no folder of pictures or videos"));
  }
  if (others != paths.end()) {
    Warn(absl::StrCat(
        "no drives, and left out: ",
        absl::StrJoin(others, paths.end(), ", ", [](std::string* out, const fs::path& path) {
          out->append(path.filename().string());
        })));
  }
  paths.erase(others, paths.end());
  return paths;
}

absl::StatusOr<std::vector<BatchEntry>> EntriesOfFolder(const std::string& input,
                                                        const BatchSettings& given) {
  if (given.out.empty()) {
    return absl::InvalidArgumentError("--out is missing; give the folder for the run folders");
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<fs::path> drives, FindDrives(input));
  std::vector<BatchEntry> entries;
  std::error_code error;
  for (const fs::path& path : drives) {
    const fs::path name = fs::is_directory(path, error) ? path.filename() : path.stem();
    Settings settings;
    settings.path = InputOf(path);
    EGOSIEVE_ASSIGN_OR_RETURN(entries.emplace_back(),
                              MakeEntry(name.string(), std::move(settings), "", "", given));
  }
  return entries;
}

absl::StatusOr<std::vector<BatchEntry>> EntriesOfManifest(const std::string& path,
                                                          const BatchSettings& given) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  auto entries = ParseManifest(text, fs::path(path).parent_path().string(), given);
  if (entries.ok()) return entries;
  return absl::InvalidArgumentError(
      absl::StrCat("the manifest ", path, " cannot be used: ", entries.status().message()));
}

}  // namespace

const std::vector<std::string>& FollowingCommands() {
  static const auto& commands =
      *new std::vector<std::string>{"refine", "masks", "render", "report"};
  return commands;
}

bool IsManifest(const std::string& input) {
  std::error_code error;
  return fs::path(input).extension() == ".toml" ||
         (fs::is_regular_file(input, error) && !vision::HasVideoExtension(input));
}

absl::StatusOr<std::vector<BatchEntry>> ReadDrives(const std::vector<std::string>& inputs,
                                                   const BatchSettings& given) {
  std::vector<BatchEntry> entries;
  for (const std::string& input : inputs) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::vector<BatchEntry> found,
        IsManifest(input) ? EntriesOfManifest(input, given) : EntriesOfFolder(input, given));
    entries.insert(entries.end(), found.begin(), found.end());
  }
  std::map<std::string, std::string> paths;  // by run folder
  for (const BatchEntry& entry : entries) {
    if (const auto [other, is_new] = paths.emplace(entry.out, entry.path); !is_new) {
      return absl::InvalidArgumentError(absl::StrCat(entry.path, " and ", other->second,
                                                     " have the same run folder, ", entry.out));
    }
  }
  return entries;
}

absl::StatusOr<std::vector<BatchEntry>> ParseManifest(absl::string_view text,
                                                      const std::string& folder,
                                                      const BatchSettings& given) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<TomlEntry> lines, ReadTomlEntries(text));
  std::vector<std::string> names;  // of the drives' tables, in their order
  Settings defaults;
  std::string shared;
  std::map<std::string, Settings> drives;
  for (const bool of_defaults : {true, false}) {
    for (const TomlEntry& line : lines) {
      const absl::Span<const std::string> keys(line.path);
      const std::string& name = keys.front();
      if ((name == "defaults") != of_defaults) continue;
      if (!of_defaults && drives.emplace(name, defaults).second) names.push_back(name);
      const absl::Status status =
          keys.size() == 1
              ? absl::InvalidArgumentError("outside the tables of the drives; write [name] above")
              : (of_defaults ? defaults : drives[name]).Set(keys.subspan(1), line);
      if (!status.ok()) {
        return absl::InvalidArgumentError(
            absl::StrCat("line ", line.line, ": ", name, ": ", status.message()));
      }
    }
    if (of_defaults) defaults.out.swap(shared);
  }
  if (names.empty()) return absl::InvalidArgumentError("it lists no drive");
  std::vector<BatchEntry> entries;
  for (const std::string& name : names) {
    absl::StatusOr<BatchEntry> entry = MakeEntry(name, drives[name], folder, shared, given);
    if (!entry.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(name, ": ", entry.status().message()));
    }
    entries.push_back(*std::move(entry));
  }
  return entries;
}

std::vector<int64_t> EqualCuts(int64_t frames, double seconds_per_frame, double minutes) {
  const double length = static_cast<double>(frames) * seconds_per_frame;
  const int64_t pieces =
      std::min(frames, static_cast<int64_t>(std::ceil(length / (60.0 * minutes))));
  std::vector<int64_t> cuts;
  for (int64_t piece = 1; piece < pieces; ++piece) cuts.push_back(piece * frames / pieces);
  return cuts;
}

void CutDrives(double minutes, std::vector<BatchEntry>& entries) {
  for (BatchEntry& entry : entries) {
    if (!entry.cuts.empty()) continue;
    vision::FrameSourceOptions options;
    for (absl::string_view flag : entry.flags) {
      double rate = 0.0;
      if (absl::ConsumePrefix(&flag, "--times=")) options.times = std::string(flag);
      if (absl::ConsumePrefix(&flag, "--fps=") && absl::SimpleAtod(flag, &rate) && rate > 0) {
        options.nominal_rate_hz = rate;
      }
    }
    const absl::StatusOr<DriveInput> input = OpenDriveInput(entry.path, 0, options);
    if (!input.ok()) continue;
    const double seconds = SecondsPerFrame(*input->frames, 0).value_or(0.0);
    if (!(seconds > 0.0)) continue;
    entry.cuts = EqualCuts(input->frames->expected_frame_count(), seconds, minutes);
  }
}

}  // namespace egosieve::tools
