#include "tools/infer/map_book.h"

#include <chrono>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/segment/drive_writer.h"

namespace egosieve::tools {
namespace {

constexpr size_t kBatch = 500;  // maps
constexpr char kLog[] = "frames.jsonl";

void SetMilliseconds(const std::string& stage, double value, FrameLine& line) {
  for (auto& [name, milliseconds] : line.milliseconds) {
    if (name == stage) {
      milliseconds = value;
      return;
    }
  }
  line.milliseconds.emplace_back(stage, value);
}

}  // namespace

absl::StatusOr<MapBook> MapBook::Open(const RunFolder& folder, const RunDescription& description,
                                      absl::Span<const FrameLine> to_be_there,
                                      const std::string& device) {
  MapBook book(folder, description, device);
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("grid")));
  EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock lock, FolderLock::TakeWhenFree(folder.path()));
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, folder.ReadLines());
  const size_t entered = lines.size();
  lines.insert(lines.end(), to_be_there.begin(), to_be_there.end());
  for (FrameLine& line : lines) {
    const int64_t index = line.index;
    book.lines_.emplace(index, std::move(line));  // what was entered stays
  }
  if (book.lines_.size() > entered) {
    std::string text;
    for (const auto& [index, line] : book.lines_) absl::StrAppend(&text, ToText(line), "\n");
    EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.File(kLog), text));
  }
  return book;
}

absl::Status MapBook::Write(const vision::SegmentedFrame& frame) {
  const auto start = std::chrono::steady_clock::now();
  const auto place = lines_.find(frame.index);
  if (place == lines_.end()) {
    return absl::NotFoundError(
        absl::StrCat("frame ", frame.index, " has no line in ", folder_.File(kLog)));
  }
  FrameLine& line = place->second;
  if (line.outcome == FrameLine::Outcome::kFailed) {
    auto before = std::make_reverse_iterator(place);
    while (before != lines_.rend() && !before->second.has_map()) ++before;
    if (before == lines_.rend()) return absl::OkStatus();
    EGOSIEVE_RETURN_IF_ERROR(CopyMaps(folder_, before->second, line));
  } else if (frame.damage.has_value()) {
    return absl::DataLossError(absl::StrCat(
        "frame ", frame.index, " could be read when it was learnt from: ", *frame.damage));
  } else {
    EGOSIEVE_ASSIGN_OR_RETURN(
        line.saturated_deviations,
        folder_.WriteGridMaps(line.index, MakeMaps(frame.map), description_.deviation_full_scale));
    line.width_pixels = frame.map.grid.width;
    line.height_pixels = frame.map.grid.height;
    line.dynamic_share = frame.record.dynamic_share;
    line.clamped_variances = frame.record.clamped_variances;
    line.map_device = device_ == description_.device ? "" : device_;
    SetMilliseconds("posterior", frame.record.milliseconds.posterior, line);
    SetMilliseconds("inference", frame.record.milliseconds.inference, line);
    const std::chrono::duration<double, std::milli> writing =
        std::chrono::steady_clock::now() - start;
    SetMilliseconds("writing", writing.count(), line);
  }
  not_entered_.push_back(frame.index);
  return not_entered_.size() < kBatch ? absl::OkStatus() : Enter();
}

absl::Status MapBook::Enter() {
  if (not_entered_.empty()) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const FolderLock lock, FolderLock::TakeWhenFree(folder_.path()));
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, folder_.ReadLines());
  size_t next = 0;
  std::string text;
  for (FrameLine& line : lines) {
    while (next < not_entered_.size() && not_entered_[next] < line.index) ++next;
    if (next < not_entered_.size() && not_entered_[next] == line.index) {
      line = lines_.at(line.index);
    }
    absl::StrAppend(&text, ToText(line), "\n");
  }
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder_.File(kLog), text));
  not_entered_.clear();
  return absl::OkStatus();
}

}  // namespace egosieve::tools
