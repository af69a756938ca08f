#include "tools/infer/map_book.h"

#include <chrono>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/segment/drive_writer.h"

namespace egosieve::tools {
namespace {

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
                                      const std::string& device) {
  MapBook book(folder, description, device);
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("grid")));
  for (const char* maps : {"grid", "potential"}) {
    kernels::RemoveAbandonedTemporaries(folder.File(maps));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, folder.ReadLines());
  for (FrameLine& line : lines) book.lines_.emplace(line.index, std::move(line));
  return book;
}

bool MapBook::Holds(int64_t index) {
  const auto line = lines_.find(index);
  if (line == lines_.end() || !line->second.has_map()) return false;
  const auto [place, is_new] = holds_.try_emplace(index, false);
  if (!place->second) place->second = folder_.HoldsMaps(line->second, description_);
  return place->second;
}

absl::Status MapBook::Add(const FrameLine& line) {
  const auto [place, is_new] = lines_.emplace(line.index, line);
  return is_new ? Append(line) : absl::OkStatus();
}

absl::Status MapBook::Append(const FrameLine& line) {
  if (!log_.has_value()) {
    EGOSIEVE_ASSIGN_OR_RETURN(log_, folder_.OpenMapLog());
  }
  return log_->Append(ToText(line));
}

absl::Status MapBook::Write(const vision::SegmentedFrame& frame) {
  const auto start = std::chrono::steady_clock::now();
  const auto place = lines_.find(frame.index);
  if (place == lines_.end()) {
    return absl::NotFoundError(
        absl::StrCat("frame ", frame.index, " has no line in ", folder_.path()));
  }
  FrameLine& line = place->second;
  if (line.outcome == FrameLine::Outcome::kFailed) {
    auto before = std::make_reverse_iterator(place);
    while (before != lines_.rend() && !Holds(before->first)) ++before;
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
  holds_[frame.index] = true;
  return Append(line);
}

}  // namespace egosieve::tools
