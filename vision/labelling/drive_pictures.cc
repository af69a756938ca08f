#include "vision/labelling/drive_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>
#include <variant>

#include "kernels/base/status_macros.h"
#include "vision/features/flow_grid.h"
#include "vision/labelling/reduced_labels.h"
#include "vision/labelling/window_tracks.h"
#include "vision/own_vehicle/fixed_pattern.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {
namespace {

constexpr int kMostPairs = 24;
constexpr double kPairSeconds = 0.08;    // least time between the two pictures of a pair
constexpr int kLongestPair = 6;          // frames
constexpr int kGridStride = 10;          // pixels
constexpr int64_t kUnknownLength = 600;  // frames, if the source does not know its length

// A readable frame.
struct ReadPicture {
  cv::Size size;  // of the original picture
  cv::Mat grey;   // equalised, reduced to kLongestDriveSide
  double seconds = 0.0;
  cv::Mat1b reduced;  // fixed_pattern.h
};

// Reads the frames of a source, and keeps those from the index of the last Forget() on.
class PictureReader {
 public:
  PictureReader(FrameSource& source, const DrivePicturesOptions& options)
      : source_(source), options_(options), first_(source.next_index()) {}

  // Frame `index`, which must not lie before the last Forget(); null if it cannot be read or the
  // drive has ended.
  absl::StatusOr<const ReadPicture*> At(int64_t index) {
    while (!has_ended_ && first_ + static_cast<int64_t>(frames_.size()) <= index) {
      has_ended_ = options_.end_frame >= 0 && source_.next_index() >= options_.end_frame;
      if (has_ended_) break;
      EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source_.Next());
      has_ended_ = std::holds_alternative<EndOfFrames>(read);
      if (has_ended_) break;
      frames_.emplace_back();
      const auto* frame = std::get_if<Frame>(&read);
      if (frame == nullptr) continue;
      const cv::Mat image = Corrected(frame->image, options_.lens.get());
      frames_.back() =
          ReadPicture{image.size(),
                      EqualizedGrey(ReducePicture(image, kLongestDriveSide), options_.equalization),
                      frame->time_seconds, ReducedPicture(EqualizedGrey(image, {}))};
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
  const DrivePicturesOptions& options_;
  std::deque<std::optional<ReadPicture>> frames_;
  int64_t first_;  // index of frames_.front()
  bool has_ended_ = false;
};

using ReadPair = std::optional<std::array<ReadPicture, 2>>;

// Nothing if the pictures cannot be used. end: set to the index after the last frame read.
absl::StatusOr<ReadPair> ReadPairAt(PictureReader& reader, int64_t index, int64_t& end) {
  std::optional<ReadPicture> first;
  end = 0;
  for (int k = 0; k <= kLongestPair; ++k) {
    EGOSIEVE_ASSIGN_OR_RETURN(const ReadPicture* picture, reader.At(index + k));
    if (reader.EndsBefore(index + k)) break;
    end = index + k + 1;
    if (picture == nullptr) continue;
    if (!first) {
      first = *picture;
      continue;
    }
    if (picture->size != first->size) break;
    if (picture->seconds - first->seconds < kPairSeconds && k < kLongestPair) continue;
    return ReadPair({*std::move(first), *picture});
  }
  return ReadPair();
}

absl::StatusOr<std::vector<PointPair>> LinksOf(const std::array<ReadPicture, 2>& pair,
                                               const cv::Mat1b& ignored) {
  std::vector<PointPair> links;
  const cv::Mat &first = pair[0].grey, &second = pair[1].grey;
  if (!IsLargeEnoughForFlow(first.size())) return links;
  FlowGridOptions options;
  options.stride_pixels = kGridStride;
  options.ignored = ReduceMask(ignored, kLongestDriveSide);
  EGOSIEVE_ASSIGN_OR_RETURN(const FlowPair flow, ComputeFlow(first, second, options.quality));
  const TrackedGrid grid = TrackGrid(flow, first, second, /*anchor_second=*/true, options);
  for (size_t i = 0; i < grid.pairs.size(); ++i) {
    if (grid.is_textured[i] == 0) continue;
    links.push_back(EnlargePair(grid.pairs[i], first.size(), pair[0].size));
  }
  return links;
}

// Corners tracked through the pictures from `index` on. end: as above.
absl::StatusOr<TrackWindow> ReadWindowAt(PictureReader& reader, int64_t index, cv::Size size,
                                         const cv::Mat1b& ignored, int64_t& end) {
  WindowTracks window;
  end = 0;
  cv::Size reduced;
  for (int k = 0; k <= kLongestWindow && !window.IsLongEnough(); ++k) {
    EGOSIEVE_ASSIGN_OR_RETURN(const ReadPicture* picture, reader.At(index + k));
    if (reader.EndsBefore(index + k)) break;
    end = index + k + 1;
    if (picture == nullptr) continue;
    if (picture->size != size) break;
    reduced = picture->grey.size();
    window.Add(picture->grey, picture->seconds);
  }
  return EnlargeTracks(window.Kept(ReduceMask(ignored, kLongestDriveSide)), reduced, size);
}

}  // namespace

absl::StatusOr<DrivePictures> ReadDrivePictures(FrameSource& source,
                                                const DrivePicturesOptions& options) {
  const int64_t known =
      (options.end_frame >= 0 ? options.end_frame : source.expected_frame_count()) -
      options.first_frame;
  const int64_t length = std::min(known > 0 ? known : kUnknownLength, kLongestDriveFrames);
  const int64_t step = std::max<int64_t>(length / kMostPairs, 1);
  const int64_t shared = length < 2 * TravelPrior::kFewestDirections ? 1 : 0;
  PictureReader reader(source, options);
  const cv::Mat1b ignored =
      options.lens != nullptr ? options.lens->CorrectMask(options.ignored) : options.ignored;
  DrivePictures drive;
  int64_t next_pair = options.first_frame, next_window = options.first_frame;
  for (int k = 0; k < kMostPairs; ++k) {
    const int64_t index = options.first_frame + k * step;
    if (index < next_pair) continue;
    EGOSIEVE_RETURN_IF_ERROR(reader.Forget(index));
    int64_t end = 0;
    EGOSIEVE_ASSIGN_OR_RETURN(const ReadPair pair, ReadPairAt(reader, index, end));
    next_pair = std::max(next_pair, end - shared);
    if (!pair) continue;
    const auto& [first, second] = *pair;
    if (drive.size.empty()) drive.size = first.size;
    if (first.size != drive.size) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<PointPair> links, LinksOf(*pair, ignored));
    drive.pairs.push_back(
        {{first.seconds, second.seconds}, {first.reduced, second.reduced}, std::move(links)});
    if (index < next_window || static_cast<int>(drive.windows.size()) >= options.windows) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(drive.windows.emplace_back(),
                              ReadWindowAt(reader, index, drive.size, ignored, end));
    next_window = std::max(end - 1, index + length / options.windows);
  }
  return drive;
}

}  // namespace egosieve::vision
