#include "tools/run_folder/run_folder.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/warning.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/map_image.h"
#include "vision/frame/ignored_area.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr char kLog[] = "frames.jsonl";
constexpr char kMapLogs[] = "log";
constexpr char kMapLogSuffix[] = ".jsonl";
constexpr size_t kNamed = 5;

// 255 where the image is not 0; empty if there is none.
absl::StatusOr<cv::Mat1b> ReadArea(const std::string& path) {
  const absl::StatusOr<cv::Mat> image = ReadImage(path, cv::IMREAD_GRAYSCALE);
  if (absl::IsNotFound(image.status())) return cv::Mat1b();
  EGOSIEVE_RETURN_IF_ERROR(image.status());
  return cv::Mat1b(*image != 0);
}

void TellWhatIsLeft(const std::string& path, std::vector<std::string> left) {
  if (left.empty()) return;
  const size_t count = left.size();
  left.resize(std::min(count, kNamed));
  Warn(absl::StrCat("left in ", path, ", not written by egosieve: ", absl::StrJoin(left, ", "),
                    count > kNamed ? absl::StrCat(" and ", count - kNamed, " more") : ""));
}

// A log's lines; none if the file is missing. A last line that a crash cut short is left out.
absl::StatusOr<std::vector<FrameLine>> ReadLog(const std::string& path) {
  std::vector<FrameLine> lines;
  const absl::StatusOr<std::string> text = ReadFile(path);
  if (absl::IsNotFound(text.status())) return lines;
  EGOSIEVE_RETURN_IF_ERROR(text.status());
  std::vector<absl::string_view> rows = absl::StrSplit(*text, '\n');
  rows.pop_back();
  for (size_t i = 0; i < rows.size(); ++i) {
    absl::StatusOr<FrameLine> line = FrameLineFromText(rows[i]);
    if (!line.ok()) {
      return absl::DataLossError(absl::StrCat(path, ", line ", i + 1, ": ", line.status().message(),
                                              "; segment the drive again"));
    }
    lines.push_back(*std::move(line));
  }
  return lines;
}

}  // namespace

std::string AbsolutePath(const std::string& path) {
  const fs::path normal = fs::absolute(path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).string();
}

cv::Mat1b IgnoredAreas::In(const FrameLine& line) const {
  const cv::Size size(line.width_pixels, line.height_pixels);
  const auto after = areas_.upper_bound(line.index);
  const bool is_known = after != areas_.begin() && std::prev(after)->second.size() == size;
  return is_known ? std::prev(after)->second.clone() : cv::Mat1b(size, uint8_t{0});
}

std::string FinishedUtc(const std::string& out) {
  const absl::StatusOr<RunFolder> folder = RunFolder::Open(out);
  if (!folder.ok()) return "";
  const absl::StatusOr<RunDescription> description = folder->ReadDescription();
  return description.ok() && description->ended == "done" ? description->finished_utc : "";
}

vision::ImageGrid GridOf(const FrameLine& line, const RunDescription& description) {
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
  absl::StatusOr<bool> barely_begun = true;
  if (fs::is_directory(path, error)) barely_begun = IsBarelyBegun(path);
  EGOSIEVE_RETURN_IF_ERROR(barely_begun.status());
  if (!*barely_begun) {
    if (!folder.ReadDescription().ok()) {
      return absl::AlreadyExistsError(
          absl::StrCat("the folder ", path,
                       " is not empty and holds no run of egosieve; choose another for --out"));
    }
    if (!overwrite) {
      return absl::AlreadyExistsError(
          absl::StrCat("the folder ", path,
                       " holds a run already; choose another for --out, or add --overwrite"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<std::string> left, RemoveFormerRun(path));
    TellWhatIsLeft(path, std::move(left));
  }
  kernels::RemoveAbandonedTemporaries(path);
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("grid")));
  return folder;
}

absl::StatusOr<std::optional<FolderLock>> RunFolder::TakeOrMake(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) EGOSIEVE_RETURN_IF_ERROR(CreateFolder(path));
  if (!fs::is_directory(path, error)) return std::nullopt;
  if (!fs::exists(RunFolder(path).File(kDescription), error)) {
    EGOSIEVE_ASSIGN_OR_RETURN(const bool barely_begun, IsBarelyBegun(path));
    if (!barely_begun) return std::nullopt;
  }
  EGOSIEVE_ASSIGN_OR_RETURN(FolderLock lock, FolderLock::Take(path));
  return std::optional<FolderLock>(std::move(lock));
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
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, ReadSegmentedLines());
  const absl::StatusOr<std::vector<std::string>> logs = ListFolder(File(kMapLogs));
  if (absl::IsNotFound(logs.status())) return lines;
  EGOSIEVE_RETURN_IF_ERROR(logs.status());
  std::map<int64_t, FrameLine> merged;
  for (FrameLine& line : lines) merged.emplace(line.index, std::move(line));
  for (const std::string& name : *logs) {
    if (!absl::EndsWith(name, kMapLogSuffix)) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> entries,
                              ReadLog(File(absl::StrCat(kMapLogs, "/", name))));
    for (FrameLine& entry : entries) {
      const auto [place, is_new] = merged.try_emplace(entry.index);
      if (is_new || entry.has_map()) place->second = std::move(entry);
    }
  }
  lines.clear();
  for (auto& [index, line] : merged) lines.push_back(std::move(line));
  return lines;
}

absl::StatusOr<std::vector<FrameLine>> RunFolder::ReadSegmentedLines() const {
  const std::string path = File(kLog);
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, ReadLog(path));
  for (size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].index <= lines[i - 1].index) {
      return absl::DataLossError(absl::StrCat(path, ", line ", i + 1, ": frame ", lines[i].index,
                                              " comes after frame ", lines[i - 1].index,
                                              "; segment the drive again"));
    }
  }
  return lines;
}

absl::StatusOr<LineLog> RunFolder::OpenMapLog() const {
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(File(kMapLogs)));
  std::array<char, 256> host = {};
  if (gethostname(host.data(), host.size() - 1) != 0) host = {"unknown"};
  for (char& letter : host) {
    if (letter == '/') letter = '_';
  }
  // The name begins with the time: of two lines of a frame, that of the later program counts.
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return LineLog::Open(
      File(absl::StrFormat("%s/%013d-%s-%d%s", kMapLogs,
                           std::chrono::duration_cast<std::chrono::milliseconds>(now).count(),
                           host.data(), getpid(), kMapLogSuffix)));
}

bool RunFolder::HoldsMaps(const FrameLine& line) const {
  const auto is_there = [&](const char* folder, const char* suffix) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(FrameFile(folder, line.index, suffix), error);
    return !error && size > 0;
  };
  return is_there("grid", ".prob.png") && is_there("grid", ".std.png");
}

absl::StatusOr<int64_t> RunFolder::WriteGridMaps(int64_t index, const FrameMaps& maps,
                                                 double deviation_full_scale) const {
  EGOSIEVE_ASSIGN_OR_RETURN(const EncodedMap probability, EncodeMap(maps.probability, 1.0));
  EGOSIEVE_ASSIGN_OR_RETURN(const EncodedMap deviation,
                            EncodeMap(maps.deviation, deviation_full_scale));
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically(FrameFile("grid", index, ".std.png"), deviation.png));
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically(FrameFile("grid", index, ".prob.png"), probability.png));
  return deviation.saturated;
}

std::string RunFolder::CameraPrefix(const std::string& path, int64_t first_frame) {
  return first_frame == 0 ? path + "/" : absl::StrFormat("%s/shots/%06d.", path, first_frame);
}

absl::StatusOr<IgnoredAreas> RunFolder::ReadIgnoredAreas() const {
  EGOSIEVE_ASSIGN_OR_RETURN(ShotList shots, ReadShots(path_));
  if (shots.first_frames.empty()) shots.first_frames = {0};
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1b ignored, ReadArea(File(kIgnored)));
  IgnoredAreas areas;
  for (const int64_t shot : shots.first_frames) {
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1b own,
                              ReadArea(CameraPrefix(path_, shot) + kOwnVehicle));
    const bool differ = !ignored.empty() && !own.empty() && own.size() != ignored.size();
    areas.Add(shot, differ ? ignored : vision::United(ignored, own));
  }
  return areas;
}

absl::StatusOr<FrameMaps> RunFolder::ReadGridMaps(const FrameLine& line,
                                                  const RunDescription& description,
                                                  bool with_deviation) const {
  const vision::ImageGrid grid = GridOf(line, description);
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
