#include "tools/run_folder/written_folder.h"

#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "tools/run_folder/former_run.h"

namespace egosieve::tools {

namespace fs = std::filesystem;

absl::Status CheckWrittenFolder(const std::string& flag, const std::string& path,
                                const std::set<std::string>& sources,
                                const std::vector<std::string>& files, bool may_hold) {
  std::error_code error;
  const std::string given = absl::StrCat(flag, "=", path);
  if (fs::exists(path, error) && !fs::is_directory(path, error)) {
    return absl::AlreadyExistsError(absl::StrCat(given, " is a file; name a folder"));
  }
  for (const std::string& source : sources) {
    if (LiesInFolder(path, source)) {
      return absl::InvalidArgumentError(
          absl::StrCat(given, " lies in what is read, ", source, "; name another folder"));
    }
  }
  if (!CheckApart(path, files).ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(given, " is or holds what is read; name another folder"));
  }
  if (!may_hold && fs::is_directory(path, error) && !fs::is_empty(path, error)) {
    return absl::AlreadyExistsError(absl::StrCat(
        given, " is not empty; name another folder, or replace its files by --overwrite"));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::tools
