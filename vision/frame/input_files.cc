#include "vision/frame/input_files.h"

#include <glob.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/image_decoding.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 14> kVideoExtensions = {
    ".mp4",  ".mov", ".avi", ".mkv",  ".m4v", ".webm", ".mpg",
    ".mpeg", ".mts", ".ts",  ".m2ts", ".3gp", ".wmv",  ".insv"};

bool IsHidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

InputFiles Chosen(const std::vector<std::string>& paths) {
  InputFiles files;
  std::copy_if(paths.begin(), paths.end(), std::back_inserter(files.paths), HasImageExtension);
  if (files.paths.empty()) {
    files.are_videos = true;
    std::copy_if(paths.begin(), paths.end(), std::back_inserter(files.paths), HasVideoExtension);
  }
  std::sort(files.paths.begin(), files.paths.end(), NaturalLess);
  return files;
}

// The visible files in a folder, and its visible folders.
absl::Status List(const fs::path& folder, std::vector<std::string>& files,
                  std::vector<fs::path>& folders) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code unknown;
    if (IsHidden(it->path())) continue;
    if (it->is_directory(unknown)) folders.push_back(it->path());
    if (it->is_regular_file(unknown)) files.push_back(it->path().string());
  }
  if (!error) return absl::OkStatus();
  return absl::NotFoundError(
      absl::StrCat(folder.string(), ": the folder cannot be read (", error.message(), ")"));
}

}  // namespace

bool HasVideoExtension(const std::string& path) {
  const std::string extension = absl::AsciiStrToLower(fs::path(path).extension().string());
  return std::find(kVideoExtensions.begin(), kVideoExtensions.end(), extension) !=
         kVideoExtensions.end();
}

absl::StatusOr<InputFiles> FilesOfFolder(const std::string& folder) {
  std::vector<std::string> paths;
  std::vector<fs::path> folders;
  EGOSIEVE_RETURN_IF_ERROR(List(folder, paths, folders));
  InputFiles files = Chosen(paths);
  if (files.paths.empty()) {
    for (size_t i = 0; i < folders.size(); ++i) {  // `folders` grows; links may form circles
      if (fs::is_symlink(folders[i])) continue;
      const fs::path below = folders[i];
      EGOSIEVE_RETURN_IF_ERROR(List(below, paths, folders));
    }
    files = Chosen(paths);
  }
  if (!files.paths.empty()) return files;
  return absl::InvalidArgumentError(absl::StrCat(
      folder,
      ": no pictures in this folder, and no videos; give one that holds PNG or JPEG files, "
      "or videos"));
}

absl::StatusOr<InputFiles> FilesOfGlob(const std::string& pattern) {
  std::vector<std::string> paths;
  size_t match_count = 0;
  glob_t matches = {};
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &matches) == 0) {
    match_count = matches.gl_pathc;
    for (size_t i = 0; i < matches.gl_pathc; ++i) {
      std::error_code error;
      const fs::path path = matches.gl_pathv[i];
      if (!IsHidden(path) && fs::is_regular_file(path, error)) paths.push_back(path.string());
    }
  }
  globfree(&matches);
  if (match_count == 0) {
    return absl::NotFoundError(
        absl::StrCat(pattern, ": no file matches; quote the pattern and check the folder"));
  }
  InputFiles files = Chosen(paths);
  if (!files.paths.empty()) return files;
  return absl::InvalidArgumentError(absl::StrCat(pattern, ": matches ", match_count,
                                                 " files, none of them a picture or a video; "
                                                 "name a video by itself"));
}

}  // namespace egosieve::vision
