#include "vision/labelling/shots.h"

#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "kernels/base/status_macros.h"
#include "vision/features/flow_grid.h"
#include "vision/frame/frame.h"
#include "vision/labelling/reduced_labels.h"
#include "vision/matching/one_scene.h"

namespace egosieve::vision {
namespace {

constexpr int kLongestSide = 320;         // pixels
constexpr int kStays = 2;                 // pictures
constexpr double kBlankDeviation = 3.0;   // grey levels
constexpr double kSameCorrelation = 0.9;  // of thumbnails: one scene, without flow
constexpr int kThumbnailReduction = 10;

struct ShotPicture {
  int64_t index = 0;
  cv::Mat1b grey, thumbnail;
};

ShotPicture Of(const Frame& frame) {
  ShotPicture picture;
  picture.index = frame.index;
  cv::cvtColor(ReducePicture(frame.image, kLongestSide), picture.grey, cv::COLOR_BGR2GRAY);
  const cv::Size size = picture.grey.size() / kThumbnailReduction;
  if (!size.empty()) cv::resize(picture.grey, picture.thumbnail, size, 0, 0, cv::INTER_AREA);
  return picture;
}

bool IsBlank(const ShotPicture& picture) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(picture.grey, mean, deviation);
  return deviation[0] < kBlankDeviation || !IsLargeEnoughForFlow(picture.grey.size());
}

absl::StatusOr<bool> AreOneScene(const ShotPicture& a, const ShotPicture& b) {
  if (a.grey.size() != b.grey.size()) return true;
  cv::Mat1f correlation;
  cv::matchTemplate(a.thumbnail, b.thumbnail, correlation, cv::TM_CCOEFF_NORMED);
  if (correlation(0, 0) >= kSameCorrelation) return true;
  EGOSIEVE_ASSIGN_OR_RETURN(const FlowPair flow, ComputeFlow(a.grey, b.grey, FlowQuality::kFast));
  return ShowOneScene(flow, a.grey, b.grey);
}

class CutFinder {
 public:
  // The first frame of a shot, if this picture proves one.
  absl::StatusOr<std::optional<int64_t>> Add(ShotPicture picture) {
    std::optional<int64_t> proven;
    if (!last_) {
      last_ = std::move(picture);
      return proven;
    }
    if (before_) {
      EGOSIEVE_ASSIGN_OR_RETURN(const bool returns, AreOneScene(*before_, picture));
      if (returns) before_.reset();
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const bool stays, AreOneScene(*last_, picture));
    if (before_ && !stays) {
      before_.reset();
    } else if (before_ && ++stayed_ == kStays) {
      proven = begin_;
      before_.reset();
    } else if (!before_ && !stays && is_calm_) {
      before_ = last_;
      begin_ = picture.index;
      stayed_ = 0;
    }
    is_calm_ = stays;
    last_ = std::move(picture);
    return proven;
  }

 private:
  std::optional<ShotPicture> last_, before_;  // before_: of the scene before a cut not yet proven
  int64_t begin_ = 0;                         // after that cut
  int stayed_ = 0;
  bool is_calm_ = true;  // the last two pictures are of one scene
};

}  // namespace

absl::StatusOr<std::vector<int64_t>> FindShots(FrameSource& source, int64_t begin, int64_t end) {
  std::vector<int64_t> shots = {begin};
  CutFinder finder;
  while (end < 0 || source.next_index() < end) {
    EGOSIEVE_ASSIGN_OR_RETURN(const FrameRead read, source.Next());
    if (std::holds_alternative<EndOfFrames>(read)) break;
    const auto* frame = std::get_if<Frame>(&read);
    if (frame == nullptr) continue;
    ShotPicture picture = Of(*frame);
    if (IsBlank(picture)) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(const std::optional<int64_t> cut, finder.Add(std::move(picture)));
    if (cut) shots.push_back(*cut);
  }
  return shots;
}

}  // namespace egosieve::vision
