#include "tools/masks/video_frames.h"

#include <opencv2/imgproc.hpp>
#include <string>
#include <variant>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"

namespace egosieve::tools {
namespace {

const cv::Size kThumbnail(64, 36);

// A thumbnail as a row, for (VF1).
cv::Mat1f Thumbnail(const cv::Mat3b& image) {
  cv::Mat small, grey;
  cv::resize(image, small, kThumbnail, 0, 0, cv::INTER_AREA);
  cv::cvtColor(small, grey, cv::COLOR_BGR2GRAY);
  cv::Mat1f row = cv::Mat1f(grey).reshape(1, 1);
  row -= cv::mean(row)[0];
  const double length = cv::norm(row);
  if (length > 0.0) row /= length;  // a picture of a single grey matches nothing
  return row;
}

struct Best {
  int64_t frame = -1;
  float agreement = -1.0F;
};

// Calls `visit` with index and thumbnail of each readable frame, beginning with the first.
absl::Status Visit(vision::FrameSource& source,
                   const std::function<absl::Status(int64_t, const cv::Mat1f&)>& visit) {
  EGOSIEVE_RETURN_IF_ERROR(AsInputError(source.SeekTo(0)));
  while (true) {
    EGOSIEVE_ASSIGN_OR_RETURN(const vision::FrameRead read, source.Next());
    if (std::holds_alternative<vision::EndOfFrames>(read)) return absl::OkStatus();
    if (const auto* frame = std::get_if<vision::Frame>(&read)) {
      EGOSIEVE_RETURN_IF_ERROR(visit(frame->index, Thumbnail(frame->image)));
    }
  }
}

}  // namespace

absl::StatusOr<std::vector<int64_t>> FindInVideo(vision::FrameSource& pictures,
                                                 vision::FrameSource& video,
                                                 const std::function<bool()>& after_frame) {
  cv::Mat1f thumbnails;
  std::vector<int64_t> indices;
  EGOSIEVE_RETURN_IF_ERROR(Visit(pictures, [&](int64_t index, const cv::Mat1f& thumbnail) {
    thumbnails.push_back(thumbnail);
    indices.push_back(index);
    return absl::OkStatus();
  }));
  std::vector<Best> best(indices.size());
  EGOSIEVE_RETURN_IF_ERROR(Visit(video, [&](int64_t frame, const cv::Mat1f& thumbnail) {
    const cv::Mat1f agreements = thumbnails * thumbnail.t();
    for (size_t i = 0; i < best.size(); ++i) {
      const float agreement = agreements(static_cast<int>(i), 0);
      if (agreement > best[i].agreement) best[i] = {frame, agreement};
    }
    return after_frame() ? absl::OkStatus()
                         : absl::CancelledError("interrupted; nothing was written");
  }));
  std::vector<int64_t> frames(pictures.expected_frame_count(), -1);
  std::string first;
  int missing = 0;
  for (size_t i = 0; i < best.size(); ++i) {
    frames[indices[i]] = best[i].frame;
    if (best[i].agreement >= kLeastAgreement) continue;
    if (missing++ > 0) continue;
    first = absl::StrFormat("%s: no frame of %s is this picture (frame %d comes nearest, by %.3f)",
                            pictures.image_name(indices[i]), video.description(), best[i].frame,
                            best[i].agreement);
  }
  if (missing == 0) return frames;
  return absl::InvalidArgumentError(
      absl::StrCat(first, missing > 1 ? absl::StrCat(", nor are ", missing - 1, " others") : "",
                   "; --from_video takes the video that the pictures were taken from"));
}

}  // namespace egosieve::tools
