#include "tools/run_folder/former_run.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <string_view>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/folder_lock.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using kernels::NameOfTemporary;

constexpr char kDescription[] = "run.json";

constexpr std::array<std::string_view, 15> kFiles = {
    "camera.json",  "own_vehicle.png", "fixed_pattern.png", "windscreen.png", "ignored.png",
    "report.html",  "overlay.mp4",     "overlay.avi",       "eval.json",      "eval.csv",
    "further.json", "tracks.csv",      "reconstruct.json",  "frames.jsonl",   "trajectory.txt"};

// Files NNNNNN with one of these endings.
struct FrameFolder {
  const char* name;
  std::vector<std::string_view> endings;
};

const std::vector<FrameFolder>& FrameFolders() {
  static const auto& folders = *new std::vector<FrameFolder>{
      {"grid", {".prob.png", ".std.png"}},
      {"full", {".prob.png", ".std.png", ".class.png", ".objects.json"}},
      {"frames", {".png"}},
      {"masks", {".png"}},
      {"ids", {".png"}},
      {"render", {".png"}},
      {"model", {".npz"}}};
  return folders;
}

bool IsFrameFile(std::string_view name, const std::vector<std::string_view>& endings) {
  const size_t digits = name.find_first_not_of("0123456789");
  return digits != std::string_view::npos && digits >= 6 &&
         std::find(endings.begin(), endings.end(), name.substr(digits)) != endings.end();
}

// Whether `name` is the page, its data, or an image of a figure that the data name.
bool IsPlotFile(std::string_view name, const std::string& figures) {
  if (name == "figures.json" || name == "index.html" || name == "plot.log") return true;
  const fs::path path(name);
  return (path.extension() == ".svg" || path.extension() == ".png") &&
         figures.find(absl::StrCat("\"", path.stem().string(), "\"")) != std::string::npos;
}

bool IsLogFile(std::string_view name) { return name.ends_with(".jsonl"); }

absl::Status Remove(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (!error) return absl::OkStatus();
  return absl::PermissionDeniedError(absl::StrCat(
      "cannot remove ", path.string(), ": ", error.message(), "; choose another folder for --out"));
}

// Removes the files of `folder` that satisfy `is_ours`, and their temporary files. Directories and
// links are never files of the program.
template <typename IsOurs>
absl::Status RemoveFiles(const fs::path& root, const std::string& folder, const IsOurs& is_ours,
                         std::vector<std::string>& left) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(root / folder, error);
  if (!fs::exists(status)) return absl::OkStatus();
  if (!fs::is_directory(status)) {
    left.push_back(folder);
    return absl::OkStatus();
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                            ListFolder((root / folder).string()));
  for (const std::string& name : names) {
    const fs::path path = root / folder / name;
    const std::string_view whole = NameOfTemporary(name);
    if (is_ours(whole.empty() ? std::string_view(name) : whole) &&
        fs::is_regular_file(fs::symlink_status(path, error))) {
      EGOSIEVE_RETURN_IF_ERROR(Remove(path));
    } else {
      left.push_back(folder.empty() ? name : absl::StrCat(folder, "/", name));
    }
  }
  // Empty folders are removed, too.
  if (!folder.empty()) fs::remove(root / folder, error);
  return absl::OkStatus();
}

// Resolves all links; of a path that does not exist, those of its existing part.
fs::path Canonical(const fs::path& path) {
  std::error_code error;
  // (of a relative path that does not exist, weakly_canonical alone gives a relative one)
  fs::path canonical = fs::weakly_canonical(fs::absolute(path), error);
  return error ? fs::absolute(path).lexically_normal() : canonical;
}

bool LiesIn(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first ==
         folder.end();
}

}  // namespace

absl::StatusOr<std::vector<std::string>> RemoveFormerRun(const std::string& path) {
  const fs::path root(path);
  std::vector<std::string> left;
  std::string figures;
  if (absl::StatusOr<std::string> text = ReadFile((root / "plots/figures.json").string());
      text.ok()) {
    figures = *std::move(text);
  }
  EGOSIEVE_RETURN_IF_ERROR(RemoveFiles(
      root, "plots", [&](std::string_view name) { return IsPlotFile(name, figures); }, left));
  EGOSIEVE_RETURN_IF_ERROR(RemoveFiles(root, "log", IsLogFile, left));
  std::vector<std::string> folders = {"plots", "log"};
  for (const FrameFolder& folder : FrameFolders()) {
    EGOSIEVE_RETURN_IF_ERROR(RemoveFiles(
        root, folder.name, [&](std::string_view name) { return IsFrameFile(name, folder.endings); },
        left));
    folders.push_back(folder.name);
  }
  std::vector<std::string> beside;
  EGOSIEVE_RETURN_IF_ERROR(RemoveFiles(
      root, "",
      [](std::string_view name) {
        return std::find(kFiles.begin(), kFiles.end(), name) != kFiles.end();
      },
      beside));
  for (const std::string& name : beside) {
    if (FolderLock::IsLockFile(name)) continue;
    const bool is_ours = name == kDescription || NameOfTemporary(name) == kDescription;
    if (is_ours) EGOSIEVE_RETURN_IF_ERROR(Remove(root / name));
    if (!is_ours && std::find(folders.begin(), folders.end(), name) == folders.end()) {
      left.push_back(name);
    }
  }
  return left;
}

void RemoveAbandonedFiles(const std::string& path) {
  kernels::RemoveAbandonedTemporaries(path);
  for (const FrameFolder& folder : FrameFolders()) {
    kernels::RemoveAbandonedTemporaries((fs::path(path) / folder.name).string());
  }
}

absl::StatusOr<bool> IsBarelyBegun(const std::string& path) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<std::string> names, ListFolder(path));
  for (const std::string& name : names) {
    if (FolderLock::IsLockFile(name)) continue;
    const fs::path entry = fs::path(path) / name;
    std::error_code error;
    const bool empty_grid =
        name == "grid" && fs::is_directory(entry, error) && fs::is_empty(entry, error) && !error;
    if (!empty_grid && NameOfTemporary(name) != kDescription) return false;
  }
  return true;
}

absl::Status CheckApart(const std::string& out, const std::vector<std::string>& sources) {
  const fs::path folder = Canonical(out);
  std::map<fs::path, fs::path> parents;  // resolved folders; few of many files are links
  for (const std::string& source : sources) {
    const fs::path path = fs::absolute(source);
    std::error_code error;
    fs::path real;
    if (fs::is_symlink(path, error) || !path.has_filename()) {
      real = Canonical(path);
    } else {
      const auto [parent, is_new] = parents.try_emplace(path.parent_path());
      if (is_new) parent->second = Canonical(parent->first);
      real = parent->second / path.filename();
    }
    if (LiesIn(real, folder)) {
      return absl::InvalidArgumentError(absl::StrCat("--out=", out, " is or holds what is read, ",
                                                     source, "; choose another folder for --out"));
    }
  }
  return absl::OkStatus();
}

bool LiesInFolder(const std::string& path, const std::string& folder) {
  return LiesIn(Canonical(path), Canonical(folder));
}

}  // namespace egosieve::tools
