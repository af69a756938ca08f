#include "tools/batch/drive_files.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// The file lies in a folder of this name beside the run folder, to avoid clashes with other files.
std::string OwnFile(const BatchEntry& entry, const std::string& suffix) {
  const fs::path out = AbsolutePath(entry.out);
  return (out.parent_path() / "egosieve_logs" / out.filename()).string() + suffix;
}

std::string NotePath(const BatchEntry& entry, const BatchStep& step) {
  return absl::StrCat(TaskNotesPath(entry), "/", step.command);
}

std::string Note(const BatchStep& step, const std::string& finished_utc) {
  return absl::StrCat(finished_utc, " ", absl::StrJoin(step.flags, " "), "\n");
}

// Whether the step's output is there; true if it is many files, which the run's lines name.
bool HasProduct(const BatchEntry& entry, const std::string& command) {
  const fs::path out = entry.out;
  std::vector<fs::path> any;
  if (command == "masks") any = {MasksPath(entry)};
  if (command == "reconstruct") any = {out / "reconstruct.json"};
  if (command == "render") any = {out / "overlay.mp4", out / "overlay.avi", out / "render"};
  if (command == "report") any = {out / "report.html"};
  return any.empty() || std::any_of(any.begin(), any.end(), [](const fs::path& path) {
           std::error_code error;
           return fs::exists(path, error);
         });
}

}  // namespace

std::string LogPath(const BatchEntry& entry) { return OwnFile(entry, ".log"); }

std::string TaskNotesPath(const BatchEntry& entry) { return OwnFile(entry, ".tasks"); }

std::string MasksPath(const BatchEntry& entry) { return absl::StrCat(entry.out, ".masks"); }

bool IsStepDone(const BatchEntry& entry, const BatchStep& step, const std::string& finished_utc) {
  return ReadFile(NotePath(entry, step)).value_or("") == Note(step, finished_utc) &&
         HasProduct(entry, step.command);
}

absl::Status NoteStepDone(const BatchEntry& entry, const BatchStep& step,
                          const std::string& finished_utc) {
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(TaskNotesPath(entry)));
  return WriteFileAtomically(NotePath(entry, step), Note(step, finished_utc));
}

}  // namespace egosieve::tools
