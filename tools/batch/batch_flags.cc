#include "tools/batch/batch_flags.h"

#include <filesystem>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "tools/batch/batch_settings.h"
#include "tools/batch/found_drives.h"
#include "tools/cli/checks.h"
#include "vision/frame/input_files.h"

namespace egosieve::tools {
namespace {

bool IsManifest(const std::string& input) {
  std::error_code error;
  const std::string extension = std::filesystem::path(input).extension().string();
  return extension == ".toml" || extension == ".json" ||
         (std::filesystem::is_regular_file(input, error) && !vision::HasVideoExtension(input));
}

}  // namespace

void BatchFlags::AddFlags(CLI::App& app) {
  app.add_option("INPUT", inputs,
                 "A folder or a glob of drives (videos, and folders of pictures or videos), or a "
                 "manifest, as JSON or TOML")
      ->required()
      ->default_str("")
      ->type_name("")
      ->configurable(false);
  app.add_option("--out", out,
                 "The folder for the run folders, which go by the drives' names; of a manifest "
                 "for drives that name none")
      ->type_name("DIR");
  app.add_option("--jobs", jobs, "Drives at the same time, which share the threads")
      ->check(Between(1, 256))
      ->type_name("NUMBER");
  plan_run.AddFlags(app);
  app.add_option(
         "--then", then,
         absl::StrCat("What follows segment, by commas: ", absl::StrJoin(FollowingCommands(), ", "),
                      "; masks go to OUT/NAME.masks. What has been done on the same run "
                      "with the same flags is left"))
      ->type_name("COMMANDS");
  app.add_option("--segment_flags", segment_flags, "Flags of segment for all drives, in quotes")
      ->type_name("FLAGS");
  app.add_option("--masks_flags", masks_flags,
                 "Flags of masks for all drives, in quotes: '--for=colmap --dilate=10'; those of "
                 "other commands go into a manifest")
      ->type_name("FLAGS");
  app.add_option("--index", index,
                 "The page of all drives, written as they go on; default: batch.html in the "
                 "folder that all run folders share")
      ->type_name("FILE");
  result.AddFlag(app);
}

absl::StatusOr<BatchFlags::Drives> BatchFlags::FindEntries() const {
  BatchSettings given;
  given.out = out;
  if (!then.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(given.then, ParseThen(then));
    given.says_then = true;
  }
  EGOSIEVE_ASSIGN_OR_RETURN(given.flags["segment"], ParseFlags(segment_flags));
  EGOSIEVE_ASSIGN_OR_RETURN(given.flags["masks"], ParseFlags(masks_flags));
  Drives drives;
  for (const std::string& input : inputs) {
    if (IsManifest(input)) {
      EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<BatchEntry> listed, ReadManifest(input, given));
      drives.entries.insert(drives.entries.end(), listed.begin(), listed.end());
      continue;
    }
    if (out.empty()) {
      return absl::InvalidArgumentError("--out is missing; give the folder for the run folders");
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const FoundDrives found, FindDrives(input));
    for (const FoundDrive& drive : found.drives) {
      drives.entries.push_back(MakeEntry(drive.name, drive.path, given));
    }
    drives.left_out.insert(drives.left_out.end(), found.left_out.begin(), found.left_out.end());
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckFolders(drives.entries));
  return drives;
}

absl::StatusOr<ExitCode> BatchFlags::RunPlan(const std::vector<BatchEntry>& entries) const {
  if (inputs.size() > 1) {
    return absl::InvalidArgumentError(
        "--engine, --task, --plan and --status take one INPUT; list the drives in a manifest");
  }
  // Files for the engine are written beside this path.
  const std::string& beside = IsManifest(inputs.front()) ? inputs.front() : out;
  return plan_run.Run(beside, entries, result);
}

}  // namespace egosieve::tools
