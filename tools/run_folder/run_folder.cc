#include "tools/run_folder/run_folder.h"

#include <filesystem>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr char kDescription[] = "run.json";
constexpr char kLog[] = "frames.jsonl";

// All that a run leaves, and what is made from it. run.json goes last: until then the folder still
// tells what it is.
constexpr const char* kProducts[] = {
    "report.html",     "overlay.mp4", "overlay.avi", "overlay.tmp.mp4",
    "overlay.tmp.avi", "eval.json",   "eval.csv",    "further.json",
    "plots",           "render",      "full",        "grid",
    "steps",           "model",       kLog,          kDescription};

// Whether the folder holds nothing but what a run that was killed before its run.json leaves.
bool IsBarelyBegun(const std::string& path, std::error_code& error) {
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    const std::string name = entry.path().filename().string();
    const bool empty_grid = name == "grid" && entry.is_directory() && fs::is_empty(entry.path());
    if (!empty_grid && name != std::string(kDescription) + ".tmp") return false;
  }
  return true;
}

// Each with the temporary file that a kill may have left of it.
absl::Status RemoveFormerRun(const std::string& path) {
  for (const std::string product : kProducts) {
    for (const std::string& name : {product + ".tmp", product}) {
      std::error_code error;
      fs::remove_all(fs::path(path) / name, error);
      if (error) {
        return absl::PermissionDeniedError(absl::StrCat("cannot remove ", path, "/", name, ": ",
                                                        error.message(),
                                                        "; choose another folder for --out"));
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

std::string AbsolutePath(const std::string& path) {
  const fs::path normal = fs::absolute(path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).string();
}

kernels::ImageGrid GridOf(const FrameLine& line, const RunDescription& description) {
  return {line.width_pixels, line.height_pixels, description.grid.stride};
}

std::string RunFolder::File(const std::string& name) const {
  return absl::StrCat(path_, "/", name);
}

std::string RunFolder::FrameFile(const std::string& folder, int64_t index,
                                 const std::string& suffix) const {
  return absl::StrFormat("%s/%s/%06d%s", path_, folder, index, suffix);
}

absl::StatusOr<RunFolder> RunFolder::Create(const std::string& path, bool overwrite) {
  std::error_code error;
  if (fs::exists(path, error) && !fs::is_directory(path, error)) {
    return absl::AlreadyExistsError(absl::StrCat(path, " is a file; choose a folder for --out"));
  }
  RunFolder folder(path);
  error.clear();
  if (fs::is_directory(path) && !IsBarelyBegun(path, error)) {
    const bool is_run = folder.ReadDescription().ok();
    if (!is_run) {
      return absl::AlreadyExistsError(
          absl::StrCat("the folder ", path,
                       " is not empty and holds no run of egosieve; choose another for --out"));
    }
    if (!overwrite) {
      return absl::AlreadyExistsError(
          absl::StrCat("the folder ", path,
                       " holds a run already; choose another for --out, or add --overwrite"));
    }
    EGOSIEVE_RETURN_IF_ERROR(RemoveFormerRun(path));
  }
  if (error) {
    return absl::PermissionDeniedError(absl::StrCat(
        "cannot look into ", path, ": ", error.message(), "; choose another folder for --out"));
  }
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("grid")));
  return folder;
}

absl::StatusOr<RunFolder> RunFolder::Open(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    return absl::NotFoundError(
        absl::StrCat("no folder ", path, "; give the folder that segment --out=DIR wrote"));
  }
  RunFolder folder(path);
  if (!fs::exists(folder.File(kDescription), error)) {
    return absl::NotFoundError(
        absl::StrCat(path, " holds no run.json; give the folder that segment --out=DIR wrote"));
  }
  return folder;
}

absl::Status RunFolder::WriteDescription(const RunDescription& description) const {
  return WriteFileAtomically(File(kDescription), ToText(description));
}

absl::StatusOr<RunDescription> RunFolder::ReadDescription() const {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(File(kDescription)));
  absl::StatusOr<RunDescription> description = RunDescriptionFromText(text);
  if (!description.ok()) {
    return absl::Status(
        description.status().code(),
        absl::StrCat(File(kDescription), " cannot be used: ", description.status().message()));
  }
  return description;
}

absl::StatusOr<std::vector<FrameLine>> RunFolder::ReadLines() const {
  const std::string path = File(kLog);
  std::vector<FrameLine> lines;
  if (std::error_code error; !fs::exists(path, error)) {
    return lines;
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  std::vector<absl::string_view> rows = absl::StrSplit(text, '\n');
  rows.pop_back();  // empty, or what a crash cut short
  for (size_t i = 0; i < rows.size(); ++i) {
    const auto damage = [&](absl::string_view what) {
      return absl::DataLossError(
          absl::StrCat(path, ", line ", i + 1, ": ", what, "; segment the drive again"));
    };
    absl::StatusOr<FrameLine> line = FrameLineFromText(rows[i]);
    if (!line.ok()) {
      return damage(line.status().message());
    }
    if (!lines.empty() && line->index <= lines.back().index) {
      return damage(absl::StrCat("frame ", line->index, " comes after frame ", lines.back().index));
    }
    lines.push_back(*std::move(line));
  }
  return lines;
}

absl::StatusOr<int64_t> RunFolder::WriteGridMaps(int64_t index, const FrameMaps& maps,
                                                 double deviation_full_scale) const {
  EGOSIEVE_ASSIGN_OR_RETURN(const EncodedMap probability, EncodeMap(maps.probability, 1.0));
  EncodedMap deviation;
  if (!maps.deviation.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(deviation, EncodeMap(maps.deviation, deviation_full_scale));
    EGOSIEVE_RETURN_IF_ERROR(
        WriteFileAtomically(FrameFile("grid", index, ".std.png"), deviation.png));
  }
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically(FrameFile("grid", index, ".prob.png"), probability.png));
  return deviation.saturated;
}

absl::StatusOr<FrameMaps> RunFolder::ReadGridMaps(const FrameLine& line,
                                                  const RunDescription& description,
                                                  bool with_deviation) const {
  const kernels::ImageGrid grid = GridOf(line, description);
  const cv::Size size(grid.columns(), grid.rows());
  FrameMaps maps;
  EGOSIEVE_ASSIGN_OR_RETURN(maps.probability,
                            ReadMap(FrameFile("grid", line.index, ".prob.png"), size, 1.0));
  if (with_deviation) {
    EGOSIEVE_ASSIGN_OR_RETURN(maps.deviation, ReadMap(FrameFile("grid", line.index, ".std.png"),
                                                      size, description.deviation_full_scale));
  }
  return maps;
}

}  // namespace egosieve::tools
