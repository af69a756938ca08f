#include "tools/batch/found_drives.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/input_files.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> Children(const fs::path& folder) {
  std::vector<fs::path> children;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    children.push_back(it->path());
  }
  return children;
}

bool Holds(const fs::path& folder, bool (*is_kind)(const std::string&)) {
  const std::vector<fs::path> children = Children(folder);
  return std::any_of(children.begin(), children.end(),
                     [&](const fs::path& child) { return is_kind(child.string()); });
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

std::vector<fs::path> Matches(const std::string& pattern) {
  glob_t found = {};
  std::vector<fs::path> matches;
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0) {
    matches.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  }
  globfree(&found);
  return matches;
}

}  // namespace

absl::StatusOr<FoundDrives> FindDrives(const std::string& input) {
  std::error_code error;
  std::vector<fs::path> paths = fs::is_directory(input, error) ? Children(input)
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
  FoundDrives found;
  for (const fs::path& path : paths) {
    if (const std::string drive = InputOf(path); drive.empty()) {
      found.left_out.push_back(path.filename().string());
    } else {
      const bool is_folder = fs::is_directory(path, error);
      found.drives.emplace_back((is_folder ? path.filename() : path.stem()).string(), drive);
    }
  }
  if (!found.drives.empty()) return found;
  return absl::InvalidArgumentError(
      fs::is_directory(input, error) && Holds(input, vision::HasImageExtension)
          ? absl::StrCat(input,
                         " holds the pictures of one drive; give it to segment, or name the "
                         "folder above it")
          : absl::StrCat(input, " has no drive: no video, and no folder of pictures or videos"));
}

}  // namespace egosieve::tools
