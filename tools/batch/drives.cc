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
constexpr char kSegment[] = "segment";

absl::Status CheckFollowing(const std::string& word) {
  if (std::ranges::count(kFollowingCommands, word) > 0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("'", word, "' is none of ", absl::StrJoin(kFollowingCommands, ", ")));
}

// "--stride" of "--stride=2"; "set=NAME" is a name, too.
absl::string_view NameOf(absl::string_view flag) {
  return flag.substr(0, flag.find('=', absl::StartsWith(flag, "--set=") ? 6 : 0));
}

// Replaces a flag of the same name.
void SetFlag(const std::string& command, const std::string& flag, BatchDrive& drive) {
  std::vector<std::string>& flags = drive.flags[command];
  std::erase_if(flags, [&](const std::string& other) { return NameOf(other) == NameOf(flag); });
  flags.push_back(flag);
}

absl::Status SetThen(const std::vector<std::string>& words, BatchDrive& drive) {
  drive.then.clear();
  for (const std::string& word : words) {
    drive.then.push_back(PresentName(word));
    EGOSIEVE_RETURN_IF_ERROR(CheckFollowing(drive.then.back()));
  }
  return absl::OkStatus();
}

absl::Status SetCuts(const std::vector<std::string>& frames, BatchDrive& drive) {
  drive.cuts.clear();
  int64_t before = 0, cut = 0;
  for (const std::string& frame : frames) {
    if (!absl::SimpleAtoi(frame, &cut) || cut <= before) {
      return absl::InvalidArgumentError("'cuts' is not an ascending list of frame numbers above 0");
    }
    drive.cuts.push_back(before = cut);
  }
  return absl::OkStatus();
}

// Sets what a line of a manifest says. keys: within the drive's table.
absl::Status SetLine(absl::Span<const std::string> keys, const TomlEntry& line, BatchDrive& drive) {
  const std::string& key = keys.back();
  const bool is_own = keys.size() == 1;
  if (is_own && key == "then") return SetThen(line.values, drive);
  if (is_own && key == "cuts") return SetCuts(line.values, drive);
  if (line.is_array || keys.size() > 2) {
    return absl::InvalidArgumentError(absl::StrCat("'", key, "' has no single value"));
  }
  const std::string& value = line.values.front();
  const std::string flag = value == "true" ? key : absl::StrCat(key, "=", value);
  if (is_own && (key == "path" || key == "out")) {
    (key == "path" ? drive.path : drive.out) = value;
  } else if (is_own) {
    SetFlag(kSegment, "--" + flag, drive);
  } else if (keys.front() == "research") {
    SetFlag(kSegment, "--set=" + flag, drive);
  } else {
    const std::string command = PresentName(keys.front());
    EGOSIEVE_RETURN_IF_ERROR(CheckFollowing(command));
    SetFlag(command, "--" + flag, drive);
  }
  return absl::OkStatus();
}

absl::Status SetGiven(const BatchSettings& given, BatchDrive& drive) {
  if (given.then) {
    EGOSIEVE_RETURN_IF_ERROR(
        SetThen(*given.then == "none"
                    ? std::vector<std::string>()
                    : absl::StrSplit(*given.then, absl::ByAnyChar(", "), absl::SkipEmpty()),
                drive));
  }
  for (const auto& [command, flags] :
       {std::pair{kSegment, given.segment_flags}, {"masks", given.masks_flags}}) {
    for (const absl::string_view flag : absl::StrSplit(flags, ' ', absl::SkipEmpty())) {
      if (!absl::StartsWith(flag, "--")) {
        return absl::InvalidArgumentError(
            absl::StrCat("'", flag, "' is no flag; write flags as --name=value"));
      }
      SetFlag(command, std::string(flag), drive);
    }
  }
  return absl::OkStatus();
}

// Applies what is given, and makes the paths absolute. folder: where the drive's begin. shared: the
// folder for run folders that nothing else names.
absl::Status Complete(const std::string& name, const fs::path& folder, const fs::path& shared,
                      const BatchSettings& given, BatchDrive& drive) {
  EGOSIEVE_RETURN_IF_ERROR(SetGiven(given, drive));
  if (drive.path.empty()) return absl::InvalidArgumentError("no 'path', the drive's input");
  const fs::path run = !drive.out.empty()   ? folder / drive.out
                       : !given.out.empty() ? fs::path(given.out) / name
                       : !shared.empty()    ? folder / shared / name
                                            : "";
  if (run.empty()) return absl::InvalidArgumentError("no 'out', the run folder to write");
  drive.path = AbsolutePath((folder / drive.path).string());
  drive.out = AbsolutePath(run.string());
  return absl::OkStatus();
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

// What the folder holds, or the pattern matches; the input itself if nothing does.
std::vector<fs::path> PathsOf(const std::string& input) {
  std::error_code error;
  if (fs::is_directory(input, error)) {
    const fs::directory_iterator children(input, error);
    return {begin(children), end(children)};
  }
  glob_t found = {};
  std::vector<fs::path> matches;
  if (glob(input.c_str(), GLOB_NOSORT | GLOB_NOCHECK, nullptr, &found) == 0) {
    matches.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  }
  globfree(&found);
  return matches;
}

// The drives in a folder or of a glob, in natural order.
absl::StatusOr<std::vector<fs::path>> FindDrives(const std::string& input) {
  std::error_code error;
  std::vector<fs::path> paths = PathsOf(input);
  if (!fs::exists(input, error) && (paths.empty() || !fs::exists(paths.front(), error))) {
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

absl::StatusOr<std::vector<BatchDrive>> DrivesOfFolder(const std::string& input,
                                                       const BatchSettings& given) {
  if (given.out.empty()) {
    return absl::InvalidArgumentError("--out is missing; give the folder for the run folders");
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<fs::path> paths, FindDrives(input));
  std::vector<BatchDrive> drives;
  std::error_code error;
  for (const fs::path& path : paths) {
    const fs::path name = fs::is_directory(path, error) ? path.filename() : path.stem();
    drives.emplace_back().path = InputOf(path);
    EGOSIEVE_RETURN_IF_ERROR(Complete(name.string(), "", "", given, drives.back()));
  }
  return drives;
}

absl::StatusOr<std::vector<BatchDrive>> DrivesOfManifest(const std::string& path,
                                                         const BatchSettings& given) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  auto drives = ParseManifest(text, fs::path(path).parent_path().string(), given);
  if (drives.ok()) return drives;
  return absl::InvalidArgumentError(
      absl::StrCat("the manifest ", path, " cannot be used: ", drives.status().message()));
}

}  // namespace

bool IsManifest(const std::string& input) {
  std::error_code error;
  return fs::path(input).extension() == ".toml" ||
         (fs::is_regular_file(input, error) && !vision::HasVideoExtension(input));
}

absl::StatusOr<std::vector<BatchDrive>> ReadDrives(const std::vector<std::string>& inputs,
                                                   const BatchSettings& given) {
  std::vector<BatchDrive> drives;
  for (const std::string& input : inputs) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::vector<BatchDrive> found,
        IsManifest(input) ? DrivesOfManifest(input, given) : DrivesOfFolder(input, given));
    drives.insert(drives.end(), found.begin(), found.end());
  }
  return drives;
}

absl::StatusOr<std::vector<BatchDrive>> ParseManifest(absl::string_view text,
                                                      const std::string& folder,
                                                      const BatchSettings& given) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<TomlEntry> lines, ReadTomlEntries(text));
  BatchDrive defaults;
  std::string shared;
  std::vector<BatchDrive> drives;
  std::map<std::string, size_t> numbers;  // of the drives, by name
  for (const bool of_defaults : {true, false}) {
    for (const TomlEntry& line : lines) {
      const absl::Span<const std::string> keys(line.path);
      const std::string& name = keys.front();
      if ((name == "defaults") != of_defaults) continue;
      if (!of_defaults && numbers.emplace(name, drives.size()).second) drives.push_back(defaults);
      const absl::Status status =
          keys.size() == 1
              ? absl::InvalidArgumentError("outside the tables of the drives; write [name] above")
              : SetLine(keys.subspan(1), line, of_defaults ? defaults : drives[numbers[name]]);
      if (!status.ok()) {
        return absl::InvalidArgumentError(
            absl::StrCat("line ", line.line, ": ", name, ": ", status.message()));
      }
    }
    if (of_defaults) defaults.out.swap(shared);
  }
  if (drives.empty()) return absl::InvalidArgumentError("it lists no drive");
  for (const auto& [name, number] : numbers) {
    const absl::Status status = Complete(name, folder, shared, given, drives[number]);
    if (!status.ok()) return absl::InvalidArgumentError(absl::StrCat(name, ": ", status.message()));
  }
  return drives;
}

std::vector<int64_t> EqualCuts(int64_t frames, double seconds_per_frame, double minutes) {
  const double length = static_cast<double>(frames) * seconds_per_frame;
  const int64_t pieces =
      std::min(frames, static_cast<int64_t>(std::ceil(length / (60.0 * minutes))));
  std::vector<int64_t> cuts;
  for (int64_t piece = 1; piece < pieces; ++piece) cuts.push_back(piece * frames / pieces);
  return cuts;
}

void CutDrives(double minutes, std::vector<BatchDrive>& drives) {
  for (BatchDrive& drive : drives) {
    if (!drive.cuts.empty()) continue;
    vision::FrameSourceOptions options;
    for (absl::string_view flag : drive.flags[kSegment]) {
      double rate = 0.0;
      if (absl::ConsumePrefix(&flag, "--times=")) options.times = std::string(flag);
      if (absl::ConsumePrefix(&flag, "--fps=") && absl::SimpleAtod(flag, &rate) && rate > 0) {
        options.nominal_rate_hz = rate;
      }
    }
    const absl::StatusOr<DriveInput> input = OpenDriveInput(drive.path, 0, options);
    if (!input.ok()) continue;
    const double seconds = SecondsPerFrame(*input->frames, 0).value_or(0.0);
    if (!(seconds > 0.0)) continue;
    drive.cuts = EqualCuts(input->frames->expected_frame_count(), seconds, minutes);
  }
}

}  // namespace egosieve::tools
