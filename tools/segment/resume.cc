#include "tools/segment/resume.h"

#include <algorithm>
#include <deque>
#include <filesystem>
#include <system_error>
#include <utility>
#include <variant>

#include "absl/strings/numbers.h"
#include "gp/io/model_file.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/repeated_picture.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr size_t kKeptCheckpoints = 2;
constexpr char kSuffix[] = ".npz";

// The frames that have a checkpoint, increasing.
absl::StatusOr<std::vector<int64_t>> ListCheckpoints(const RunFolder& folder) {
  std::vector<int64_t> indices;
  const absl::StatusOr<std::vector<std::string>> names = ListFolder(folder.File("model"));
  if (absl::IsNotFound(names.status())) return indices;
  EGOSIEVE_RETURN_IF_ERROR(names.status());
  for (const std::string& name : *names) {
    int64_t index = 0;
    const fs::path path(name);
    if (path.extension() == kSuffix && absl::SimpleAtoi(path.stem().string(), &index)) {
      indices.push_back(index);
    }
  }
  std::sort(indices.begin(), indices.end());
  return indices;
}

// If the removal fails, one checkpoint too many does no harm.
void RemoveCheckpoint(const RunFolder& folder, int64_t index) {
  std::error_code error;
  fs::remove(folder.FrameFile("model", index, kSuffix), error);
}

// Removes the checkpoints of all but the last two of these frames, which are increasing.
void RemoveOldest(const RunFolder& folder, const std::vector<int64_t>& indices) {
  for (size_t i = 0; i + kKeptCheckpoints < indices.size(); ++i) {
    RemoveCheckpoint(folder, indices[i]);
  }
}

}  // namespace

absl::Status WriteCheckpoint(const RunFolder& folder, int64_t index, const std::string& bytes) {
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("model")));
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.FrameFile("model", index, kSuffix), bytes));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> indices, ListCheckpoints(folder));
  RemoveOldest(folder, indices);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<FrameLine>> ReadWholeLines(const RunFolder& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, folder.ReadSegmentedLines());
  const auto is_whole = [&](const FrameLine& line) {
    return !line.has_map() || folder.HoldsMaps(line);
  };
  lines.erase(std::find_if_not(lines.begin(), lines.end(), is_whole), lines.end());
  return lines;
}

absl::StatusOr<ResumePoint> FindResumePoint(const RunFolder& folder, int64_t from,
                                            std::vector<FrameLine> lines) {
  ResumePoint point;
  point.next_frame = from;
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<int64_t> checkpoints, ListCheckpoints(folder));
  for (; !checkpoints.empty() && point.checkpoint.empty(); checkpoints.pop_back()) {
    const int64_t index = checkpoints.back();
    if (lines.empty() || index > lines.back().index) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(std::string bytes,
                              ReadFile(folder.FrameFile("model", index, kSuffix)));
    if (!gp::ParseModel(bytes).ok()) continue;
    point.checkpoint = std::move(bytes);
    point.next_frame = index + 1;
  }
  for (FrameLine& line : lines) {
    if (line.index < point.next_frame) point.lines.push_back(std::move(line));
  }
  return point;
}

absl::StatusOr<std::vector<vision::Frame>> ReadRecentFrames(vision::FrameSource& source,
                                                            int64_t from, int64_t last, int count) {
  // Damaged and repeated frames make the stretch too short: it doubles until it is long enough.
  for (int64_t stretch = count + 1;; stretch *= 2) {
    const int64_t first = std::max(from, last - stretch + 1);
    EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(first));
    std::deque<vision::Frame> recent;
    while (source.next_index() <= last) {
      EGOSIEVE_ASSIGN_OR_RETURN(vision::FrameRead read, source.Next());
      if (std::holds_alternative<vision::EndOfFrames>(read)) break;
      if (auto* frame = std::get_if<vision::Frame>(&read)) {
        vision::AppendPicture(std::move(*frame), recent);
        if (recent.size() > static_cast<size_t>(count) + 1) recent.pop_front();
      }
    }
    // One picture more is read, since the first may be a repeat whose beginning was not read.
    if (recent.size() > static_cast<size_t>(count) || first == from) {
      if (recent.size() > static_cast<size_t>(count)) recent.pop_front();
      return std::vector<vision::Frame>(recent.begin(), recent.end());
    }
  }
}

absl::Status RemoveOtherCheckpoints(const RunFolder& folder, int64_t next_frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<int64_t> indices, ListCheckpoints(folder));
  for (; !indices.empty() && indices.back() >= next_frame; indices.pop_back()) {
    RemoveCheckpoint(folder, indices.back());
  }
  RemoveOldest(folder, indices);
  return absl::OkStatus();
}

}  // namespace egosieve::tools
