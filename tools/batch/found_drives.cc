#include "tools/batch/found_drives.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/input_files.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

bool IsHidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

// The entries of the folder itself, without hidden ones.
std::vector<fs::path> Children(const fs::path& folder) {
  std::vector<fs::path> children;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (!IsHidden(it->path())) children.push_back(it->path());
  }
  return children;
}

bool HoldsPictures(const fs::path& folder, bool or_videos) {
  const std::vector<fs::path> children = Children(folder);
  return std::any_of(children.begin(), children.end(), [&](const fs::path& child) {
    return vision::HasImageExtension(child.string()) ||
           (or_videos && vision::HasVideoExtension(child.string()));
  });
}

// The path for segment; empty if the path is not a drive.
std::string InputOf(const fs::path& path) {
  std::error_code error;
  if (fs::is_regular_file(path, error)) {
    return vision::HasVideoExtension(path.string()) ? path.string() : "";
  }
  if (!fs::is_directory(path, error)) return "";
  for (const fs::path& folder : {path, path / "frames", path / "images"}) {
    if (HoldsPictures(folder, /*or_videos=*/true)) return folder.string();
  }
  return "";
}

absl::StatusOr<std::vector<fs::path>> Candidates(const std::string& input) {
  std::error_code error;
  if (fs::is_directory(input, error)) {
    const std::vector<fs::path> children = Children(input);
    const bool has_drives = std::any_of(children.begin(), children.end(), [](const fs::path& path) {
      return !InputOf(path).empty();
    });
    if (!has_drives && HoldsPictures(input, /*or_videos=*/false)) {
      return absl::InvalidArgumentError(
          absl::StrCat(input,
                       " holds the pictures of one drive; give it to segment, or name the "
                       "folder above it"));
    }
    return children;
  }
  if (fs::exists(input, error)) return std::vector<fs::path>{input};
  std::vector<fs::path> matches;
  glob_t found = {};
  if (glob(input.c_str(), GLOB_NOSORT, nullptr, &found) == 0) {
    for (size_t i = 0; i < found.gl_pathc; ++i) {
      if (!IsHidden(found.gl_pathv[i])) matches.emplace_back(found.gl_pathv[i]);
    }
  }
  globfree(&found);
  if (matches.empty()) {
    return absl::NotFoundError(
        absl::StrCat("there is no ", input, ", and no file matches it; quote a pattern"));
  }
  return matches;
}

}  // namespace

absl::StatusOr<FoundDrives> FindDrives(const std::string& input) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<fs::path> candidates, Candidates(input));
  std::sort(candidates.begin(), candidates.end(), [](const fs::path& a, const fs::path& b) {
    return vision::NaturalLess(a.string(), b.string());
  });
  FoundDrives found;
  std::map<std::string, std::string> names;
  for (const fs::path& path : candidates) {
    const std::string drive = InputOf(path);
    std::error_code error;
    const bool is_folder = fs::is_directory(path, error);
    if (drive.empty()) {
      found.left_out.push_back(path.filename().string());
      continue;
    }
    const std::string name = is_folder ? path.filename().string() : path.stem().string();
    if (const auto [other, is_new] = names.emplace(name, path.string()); !is_new) {
      return absl::InvalidArgumentError(absl::StrCat(other->second, " and ", path.string(),
                                                     " would have one run folder, ", name,
                                                     "; rename one of them, or write a manifest"));
    }
    found.drives.push_back({name, drive});
  }
  if (found.drives.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(input, " has no drive: no video, and no folder of pictures or videos"));
  }
  return found;
}

}  // namespace egosieve::tools
