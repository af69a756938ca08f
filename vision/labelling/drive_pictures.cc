#include "vision/labelling/drive_pictures.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/features/flow_grid.h"
#include "vision/labelling/reduced_labels.h"
#include "vision/labelling/window_tracks.h"
#include "vision/own_vehicle/fixed_pattern.h"

namespace egosieve::vision {
namespace {

constexpr double kPairSeconds = 0.08;    // least time between the two pictures of a pair
constexpr double kGroundSeconds = 0.15;  // from the first picture to the last one for the ground
constexpr int kLongestPair = 6;          // frames
constexpr int kGridStride = 10;          // pixels
constexpr int64_t kUnknownLength = 600;  // frames, if the source does not know its length

// A readable frame.
struct ReadPicture {
  cv::Size size;  // of the original picture
  TimedPicture picture;
  cv::Mat1b reduced;
};

// Reads the frames of a source, and keeps those from the index of the last Forget() on.
class PictureReader {
 public:
  PictureReader(FrameSource& source, const EqualizationOptions& equalization)
      : source_(source), equalization_(equalization), first_(source.next_index()) {}

  // Frame `index`, which must not lie before the last Forget(); null if it cannot be read or the
  // drive has ended.
  absl::StatusOr<const ReadPicture*> At(int64_t index) {
    while (!has_ended_ && first_ + static_cast<int64_t>(frames_.size()) <= index) {
      EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source_.Next());
      has_ended_ = std::holds_alternative<EndOfFrames>(read);
      if (has_ended_) break;
      frames_.emplace_back();
      const auto* frame = std::get_if<Frame>(&read);
      if (frame == nullptr) continue;
      frames_.back() =
          ReadPicture{frame->image.size(),
                      {EqualizedGrey(ReducePicture(frame->image, kLongestDriveSide), equalization_),
                       frame->time_seconds},
                      ReducedPicture(EqualizedGrey(frame->image, {}))};
    }
    const auto at = static_cast<size_t>(index - first_);
    if (at >= frames_.size() || !frames_[at]) return nullptr;
    return &*frames_[at];
  }

  // After At(index): whether the drive ends before `index`.
  bool EndsBefore(int64_t index) const {
    return has_ended_ && first_ + static_cast<int64_t>(frames_.size()) <= index;
  }

  // Drops the frames before `index`, and seeks to it if it lies ahead.
  absl::Status Forget(int64_t index) {
    while (first_ < index && !frames_.empty()) {
      frames_.pop_front();
      ++first_;
    }
    if (first_ >= index || has_ended_) return absl::OkStatus();
    first_ = index;
    return source_.SeekTo(index);
  }

 private:
  FrameSource& source_;
  EqualizationOptions equalization_;
  std::deque<std::optional<ReadPicture>> frames_;
  int64_t first_;  // index of frames_.front()
  bool has_ended_ = false;
};

struct ReadPair {
  std::optional<PicturePair> pair;  // without links; nullopt if the pictures cannot be used
  cv::Size size;
  int64_t end = 0;  // index after the last frame read
};

// Reads until the pair is complete and either the ground has its pictures or `most_pictures` are
// read.
absl::StatusOr<ReadPair> ReadPairAt(PictureReader& reader, int64_t index, int64_t most_pictures) {
  ReadPair read;
  PicturePair pair;
  for (int k = 0; k <= kLongestPair; ++k) {
    EGOSIEVE_ASSIGN_OR_RETURN(const ReadPicture* picture, reader.At(index + k));
    if (reader.EndsBefore(index + k)) break;
    read.end = index + k + 1;
    if (picture == nullptr) continue;
    if (pair.pictures.empty()) {
      read.size = picture->size;
      pair.reduced = picture->reduced;
    }
    if (picture->size != read.size) break;
    pair.pictures.push_back(picture->picture);
    const double length = picture->picture.seconds - pair.seconds();
    if (pair.second == 0 && (length >= kPairSeconds || k == kLongestPair)) {
      pair.second = pair.pictures.size() - 1;
      pair.second_reduced = picture->reduced;
    }
    if (length >= kGroundSeconds || (pair.second > 0 && k + 1 >= most_pictures)) break;
  }
  if (pair.second > 0) read.pair = std::move(pair);
  return read;
}

absl::StatusOr<std::vector<PointPair>> LinksOf(const PicturePair& pair, cv::Size size,
                                               const cv::Mat1b& ignored) {
  std::vector<PointPair> links;
  const cv::Mat &first = pair.pictures[0].grey, &second = pair.pictures[pair.second].grey;
  if (!IsLargeEnoughForFlow(first.size())) return links;
  FlowGridOptions options;
  options.stride_pixels = kGridStride;
  options.ignored = ReduceMask(ignored, kLongestDriveSide);
  EGOSIEVE_ASSIGN_OR_RETURN(const FlowPair flow, ComputeFlow(first, second, options.quality));
  const TrackedGrid grid = TrackGrid(flow, first, second, /*anchor_second=*/true, options);
  for (size_t i = 0; i < grid.pairs.size(); ++i) {
    if (grid.is_textured[i] == 0) continue;
    links.push_back(EnlargePair(grid.pairs[i], first.size(), size));
  }
  return links;
}

struct ReadWindow {
  TrackWindow window;
  int64_t end = 0;  // index after the last frame read
};

// Corners tracked through the pictures from `index` on.
absl::StatusOr<ReadWindow> ReadWindowAt(PictureReader& reader, int64_t index, cv::Size size,
                                        const cv::Mat1b& ignored) {
  ReadWindow read;
  WindowTracks window;
  cv::Size reduced;
  for (int k = 0; k <= kLongestWindow && !window.IsLongEnough(); ++k) {
    EGOSIEVE_ASSIGN_OR_RETURN(const ReadPicture* picture, reader.At(index + k));
    if (reader.EndsBefore(index + k)) break;
    read.end = index + k + 1;
    if (picture == nullptr) continue;
    if (picture->size != size) break;
    reduced = picture->picture.grey.size();
    window.Add(picture->picture.grey, picture->picture.seconds);
  }
  read.window = EnlargeTracks(window.Kept(ReduceMask(ignored, kLongestDriveSide)), reduced, size);
  return read;
}

}  // namespace

absl::Status DrivePicturesOptions::Validate() const {
  if (pairs < 1 || windows < 0 || longest_frames < 1 || first_frame < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("pairs is ", pairs, ", windows ", windows, ", longest_frames ", longest_frames,
                     ", first_frame ", first_frame,
                     "; pairs and longest_frames must be positive, the others not negative"));
  }
  return equalization.Validate();
}

absl::StatusOr<DrivePictures> ReadDrivePictures(FrameSource& source,
                                                const DrivePicturesOptions& options) {
  const int64_t known = source.expected_frame_count() - options.first_frame;
  const int64_t length = std::min(known > 0 ? known : kUnknownLength, options.longest_frames);
  const int64_t step = std::max<int64_t>(length / options.pairs, 1);
  PictureReader reader(source, options.equalization);
  DrivePictures drive;
  int64_t next_pair = options.first_frame, next_window = options.first_frame;
  for (int k = 0; k < options.pairs; ++k) {
    const int64_t index = options.first_frame + k * step;
    if (index < next_pair) continue;
    EGOSIEVE_RETURN_IF_ERROR(reader.Forget(index));
    EGOSIEVE_ASSIGN_OR_RETURN(ReadPair read, ReadPairAt(reader, index, step));
    next_pair = std::max(next_pair, read.end);
    if (!read.pair) continue;
    if (drive.size.empty()) drive.size = read.size;
    if (read.size != drive.size) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(read.pair->links, LinksOf(*read.pair, drive.size, options.ignored));
    drive.pairs.push_back(*std::move(read.pair));
    if (index < next_window || static_cast<int>(drive.windows.size()) >= options.windows) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(ReadWindow window,
                              ReadWindowAt(reader, index, drive.size, options.ignored));
    next_window = std::max(window.end - 1, index + length / options.windows);
    drive.windows.push_back(std::move(window.window));
  }
  return drive;
}

}  // namespace egosieve::vision
