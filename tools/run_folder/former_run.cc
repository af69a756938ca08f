#include "tools/run_folder/former_run.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <regex>
#include <string_view>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using kernels::NameOfTemporary;

constexpr const char* kFolders[] = {"plots", "log", "grid",   "full",  "frames",
                                    "masks", "ids", "render", "model", "shots"};

// Whether the program writes a file of this path in the run folder.
bool IsOwnPath(const std::string& path) {
  static const auto& own = *new std::regex(
      "(run|camera|shots|eval|further|reconstruct)\\.json|frames\\.jsonl|(eval|tracks)\\.csv|"
      "(own_vehicle|fixed_pattern|windscreen|ignored|preview)\\.png|trajectory\\.txt|report\\.html|"
      "overlay\\.mp4|view\\.rrd|log/[^/]*\\.jsonl|grid/[0-9]{6,}\\.(prob|std)\\.png|"
      "full/[0-9]{6,}\\.((prob|std|class)\\.png|objects\\.json)|"
      "(frames|masks|ids|render)/[0-9]{6,}\\.png|model/[0-9]{6,}\\.npz|"
      "shots/[0-9]{6,}\\.(camera\\.json|(own_vehicle|fixed_pattern|windscreen)\\.png)|"
      "plots/(figures\\.json|index\\.html|plot\\.log|(roc|precision_recall|iou_by_threshold|"
      "reliability|sparsification|auc_by_frame)\\.(svg|png))");
  return std::regex_match(path, own);
}

absl::Status Remove(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (!error) return absl::OkStatus();
  return absl::PermissionDeniedError(absl::StrCat(
      "cannot remove ", path.string(), ": ", error.message(), "; choose another folder for --out"));
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
  std::vector<std::string> left, last;
  std::vector<fs::path> folders(std::begin(kFolders), std::end(kFolders));
  folders.emplace_back();
  for (const fs::path& folder : folders) {
    std::error_code error;
    if (!fs::is_directory(fs::symlink_status(root / folder, error))) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                              ListFolder((root / folder).string()));
    for (const std::string& name : names) {
      const std::string_view whole = NameOfTemporary(name);
      const fs::path file = folder / name, own = folder / (whole.empty() ? name : whole);
      const fs::file_status status = fs::symlink_status(root / file, error);
      if (IsOwnPath(own.string()) && fs::is_regular_file(status)) {
        if (own == RunFolder::kDescription) {
          last.push_back(name);
        } else {
          EGOSIEVE_RETURN_IF_ERROR(Remove(root / file));
        }
      } else if (!FolderLock::IsLockFile(file.string()) &&
                 !(fs::is_directory(status) && std::ranges::count(kFolders, file.string()) > 0)) {
        left.push_back(file.string());
      }
    }
    // Empty folders are removed, too.
    if (!folder.empty()) fs::remove(root / folder, error);
  }
  for (const std::string& name : last) EGOSIEVE_RETURN_IF_ERROR(Remove(root / name));
  return left;
}

void RemoveAbandonedFiles(const std::string& path) {
  kernels::RemoveAbandonedTemporaries(path);
  for (const char* folder : kFolders) {
    kernels::RemoveAbandonedTemporaries(absl::StrCat(path, "/", folder));
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
    if (!empty_grid && NameOfTemporary(name) != RunFolder::kDescription) return false;
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
