#include "vision/labelling/drive_camera.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/features/flow_grid.h"
#include "vision/trajectory/focal_posterior.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {
namespace {

constexpr double kPairSeconds = 0.08;  // from the first picture of a pair to the second, at least
constexpr int kLongestPair = 6;        // frames
constexpr int kGridStride = 10;        // pixels
constexpr int64_t kFewestLinks = 100;
constexpr int64_t kUnknownLength = 600;  // frames, where the source does not know its own

struct PicturePair {
  cv::Mat first, second;  // grey, equalised
};

// Nothing at the end of the input, and where the pictures of a pair cannot be used.
absl::StatusOr<std::optional<PicturePair>> ReadPair(FrameSource& source,
                                                    const EqualizationOptions& equalization) {
  std::optional<Frame> first;
  for (int k = 0; k <= kLongestPair; ++k) {
    EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source.Next());
    if (std::holds_alternative<EndOfFrames>(read)) return std::nullopt;
    auto* frame = std::get_if<Frame>(&read);
    if (frame == nullptr) continue;
    if (!first) {
      first = std::move(*frame);
      continue;
    }
    if (frame->image.size() != first->image.size()) return std::nullopt;
    if (frame->time_seconds - first->time_seconds < kPairSeconds && k < kLongestPair) continue;
    return PicturePair{EqualizedGrey(first->image, equalization),
                       EqualizedGrey(frame->image, equalization)};
  }
  return std::nullopt;
}

absl::StatusOr<std::vector<PointPair>> Links(const PicturePair& pictures) {
  std::vector<PointPair> links;
  if (!IsLargeEnoughForFlow(pictures.first.size())) return links;
  FlowGridOptions options;
  options.stride_pixels = kGridStride;
  EGOSIEVE_ASSIGN_OR_RETURN(const FlowPair flow,
                            ComputeFlow(pictures.first, pictures.second, options.quality));
  const TrackedGrid grid =
      TrackGrid(flow, pictures.first, pictures.second, /*anchor_second=*/true, options);
  for (size_t i = 0; i < grid.pairs.size(); ++i) {
    if (grid.is_textured[i] != 0) links.push_back(grid.pairs[i]);
  }
  return links;
}

}  // namespace

absl::Status DriveCameraOptions::Validate() const {
  if (pairs < 1 || longest_frames < 1 || first_frame < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("pairs is ", pairs, ", longest_frames ", longest_frames, ", first_frame ",
                     first_frame, "; they must be positive, the last not negative"));
  }
  return equalization.Validate();
}

absl::StatusOr<DriveCamera> LearnDriveCamera(FrameSource& source,
                                             const DriveCameraOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  const int64_t known = source.expected_frame_count() - options.first_frame;
  const int64_t length = std::min(known > 0 ? known : kUnknownLength, options.longest_frames);
  const int64_t step = std::max<int64_t>(length / options.pairs, 1);
  FocalPosterior posterior;
  DriveCamera camera;
  for (int k = 0; k < options.pairs; ++k) {
    const int64_t index = options.first_frame + k * step;
    if (index < source.next_index()) continue;
    EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(index));
    EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<PicturePair> pictures,
                              ReadPair(source, options.equalization));
    if (!pictures) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<PointPair> links, Links(*pictures));
    if (static_cast<int64_t>(links.size()) < kFewestLinks) continue;
    const cv::Size size = pictures->first.size();
    const Pinhole guess =
        Pinhole::Of(size, posterior.Estimate() * std::max(size.width, size.height));
    posterior.Observe(links, guess, EstimateTwoViewMotion(links, guess, {}), size);
    ++camera.pair_count;
  }
  camera.focal_ratio = posterior.Estimate();
  camera.log_focal_deviation = posterior.LogDeviation();
  return camera;
}

}  // namespace egosieve::vision
