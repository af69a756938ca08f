#include "tools/evaluate/drive_truth.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluation/map_sample.h"
#include "vision/image/inside.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// Maps in [0, 1] or [0, full_scale] as 16-bit pixels, as they are written to files.
cv::Mat1w AsWritten(const cv::Mat1f& values, double full_scale) {
  cv::Mat1w pixels(values.size());
  for (int y = 0; y < values.rows; ++y) {
    for (int x = 0; x < values.cols; ++x) pixels(y, x) = ScoreOf(values(y, x) / full_scale);
  }
  return pixels;
}

template <typename T>
cv::Mat_<T> AtGrid(const cv::Mat_<T>& image, const kernels::ImageGrid& grid) {
  cv::Mat_<T> sampled(grid.rows(), grid.columns());
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      sampled(row, column) = image(grid.y_pixels(row), grid.x_pixels(column));
    }
  }
  return sampled;
}

// Frames by the number in their names; empty if a name has no number or two have the same.
std::map<int64_t, int64_t> IndicesByNumber(const std::vector<std::string>& names) {
  std::map<int64_t, int64_t> indices;
  for (size_t i = 0; i < names.size(); ++i) {
    const std::optional<int64_t> number = NumberInName(names[i]);
    if (!number || !indices.emplace(*number, static_cast<int64_t>(i)).second) return {};
  }
  return indices;
}

}  // namespace

bool IsVoid(const ScoredFrame& frame) {
  return frame.truth.empty() || std::all_of(frame.truth.begin(), frame.truth.end(),
                                            [](uint8_t truth) { return truth == kTruthVoid; });
}

absl::StatusOr<DriveTruth> DriveTruth::Open(const std::string& path, const TruthFrames& frames,
                                            MatchMasks match) {
  DriveTruth truth;
  truth.path_ = fs::absolute(path).lexically_normal().string();
  std::error_code error;
  if (fs::is_regular_file(path, error)) {
    EGOSIEVE_RETURN_IF_ERROR(truth.OpenTracks(path, frames, match));
  } else {
    EGOSIEVE_RETURN_IF_ERROR(truth.OpenMasks(path, frames, match));
  }
  return truth;
}

absl::Status DriveTruth::OpenTracks(const std::string& path, const TruthFrames& frames,
                                    MatchMasks match) {
  EGOSIEVE_ASSIGN_OR_RETURN(TrackTruth tracks, ReadTrackTruth(path));
  if (match == MatchMasks::kOrder) {
    return absl::InvalidArgumentError(
        "tracks name their frames and cannot be matched by order; leave --match out");
  }
  kind_ = "tracks";
  std::map<int64_t, int64_t> indices;
  if (match != MatchMasks::kNumber) indices = IndicesByNumber(frames.names);
  matched_by_ = indices.empty() ? "number" : "name";
  int64_t behind = frames.names.empty() ? 0 : static_cast<int64_t>(frames.names.size());
  for (auto& [number, points] : tracks.frames) {
    const auto named = indices.find(number);
    int64_t index = number;
    if (!indices.empty()) index = named != indices.end() ? named->second : behind++;
    frames_.insert(index);
    tracks_[index] = std::move(points);
  }
  return absl::OkStatus();
}

absl::Status DriveTruth::OpenMasks(const std::string& path, const TruthFrames& frames,
                                   MatchMasks match) {
  kind_ = "masks";
  std::string folder = path;
  if (IsSyntheticTruth(path)) {
    kind_ = "synthetic";
    EGOSIEVE_ASSIGN_OR_RETURN(synthetic_, ReadSyntheticTruth(path));
    folder = (fs::path(synthetic_.folder) / "masks").string();
  }
  EGOSIEVE_ASSIGN_OR_RETURN(TruthMasks masks, ListTruthMasks(folder, frames.names, match));
  matched_by_ = masks.matched_by;
  int64_t behind = frames.indices.empty() ? 0 : frames.indices.back() + 1;
  for (auto& [key, mask] : masks.paths) {
    int64_t index = key;
    if (matched_by_ == "order") {  // mask k belongs to the k-th frame
      const bool has_frame = key < static_cast<int64_t>(frames.indices.size());
      index = has_frame ? frames.indices[key] : behind++;
    }
    frames_.insert(index);
    masks_[index] = std::move(mask);
  }
  return absl::OkStatus();
}

int64_t DriveTruth::points() const {
  int64_t count = 0;
  for (const auto& [frame, points] : tracks_) count += static_cast<int64_t>(points.size());
  return count;
}

const std::vector<LabelledPoint>& DriveTruth::PointsOf(int64_t frame) const {
  static const std::vector<LabelledPoint>& none = *new std::vector<LabelledPoint>();
  const auto found = tracks_.find(frame);
  return found == tracks_.end() ? none : found->second;
}

absl::StatusOr<cv::Mat1b> DriveTruth::ReadMask(int64_t frame, cv::Size size) const {
  const auto mask = masks_.find(frame);
  if (mask == masks_.end()) {
    return absl::FailedPreconditionError(
        absl::StrCat("frame ", frame, " has no mask in ", path_, "; its truth is ", kind_));
  }
  return ReadTruthMask(mask->second, size);
}

absl::StatusOr<cv::Mat1i> DriveTruth::ReadIds(int64_t frame, cv::Size size) const {
  if (synthetic_.frames.count(frame) == 0) return cv::Mat1i();
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1i ids, synthetic_.ReadMovingIds(frame));
  return ids.size() == size ? ids : cv::Mat1i();
}

ScoredFrame DriveTruth::CompareTracks(int64_t frame, const kernels::ImageGrid& grid,
                                      const FrameMaps& maps, double deviation_full_scale,
                                      int64_t* points_outside) const {
  std::vector<LabelledPoint> inside;
  for (const LabelledPoint& point : PointsOf(frame)) {
    if (vision::IsInside(point.x, point.y, {grid.width, grid.height})) {
      inside.push_back(point);
    } else {
      ++*points_outside;
    }
  }
  const int count = static_cast<int>(inside.size());
  ScoredFrame scored;
  scored.index = frame;
  scored.scattered = true;
  scored.probability.create(1, count);
  scored.truth.create(1, count);
  if (!maps.deviation.empty()) scored.deviation.create(1, count);
  for (int i = 0; i < count; ++i) {
    const LabelledPoint& point = inside[i];
    scored.probability(0, i) = ScoreOf(InterpolateAt(maps.probability, grid, point.x, point.y));
    scored.truth(0, i) = point.dynamic() ? kTruthDynamic : kTruthStatic;
    if (!maps.deviation.empty()) {
      scored.deviation(0, i) =
          ScoreOf(InterpolateAt(maps.deviation, grid, point.x, point.y) / deviation_full_scale);
    }
  }
  return scored;
}

absl::StatusOr<ScoredFrame> DriveTruth::Compare(int64_t frame, const kernels::ImageGrid& grid,
                                                const FrameMaps& maps, double deviation_full_scale,
                                                int64_t* points_outside) const {
  if (scattered()) return CompareTracks(frame, grid, maps, deviation_full_scale, points_outside);
  const cv::Size size(grid.width, grid.height);
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1b mask, ReadMask(frame, size));
  ScoredFrame scored;
  scored.index = frame;
  scored.probability = AsWritten(maps.probability, 1.0);
  if (!maps.deviation.empty()) scored.deviation = AsWritten(maps.deviation, deviation_full_scale);
  scored.truth = AtGrid(mask, grid);
  if (ObjectsOf(frame) != nullptr) {
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1i ids, ReadIds(frame, size));
    if (!ids.empty()) {
      scored.ids = AtGrid(ids, grid);
      scored.objects = ObjectsOf(frame);
    }
  }
  return scored;
}

const std::map<int, SyntheticObject>* DriveTruth::ObjectsOf(int64_t frame) const {
  const auto objects = synthetic_.frames.find(frame);
  return objects != synthetic_.frames.end() ? &objects->second : nullptr;
}

}  // namespace egosieve::tools
