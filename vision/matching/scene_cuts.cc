#include "vision/matching/scene_cuts.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <variant>

#include "absl/status/status.h"
#include "kernels/base/status_macros.h"
#include "vision/features/flow_grid.h"
#include "vision/matching/scene_agreement.h"

namespace egosieve::vision {
namespace {

constexpr int kWidth = 320;

cv::Mat SmallGrey(const cv::Mat& image) {
  cv::Mat grey, small;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (grey.cols <= kWidth) return grey;
  cv::resize(grey, small, {kWidth, std::max(1, grey.rows * kWidth / grey.cols)}, 0, 0,
             cv::INTER_AREA);
  return small;
}

absl::StatusOr<bool> AreOneScene(const cv::Mat& first, const cv::Mat& second) {
  if (first.size() != second.size()) return false;
  if (!IsLargeEnoughForFlow(first.size())) return true;
  EGOSIEVE_ASSIGN_OR_RETURN(const FlowPair flow, ComputeFlow(first, second, FlowQuality::kFast));
  const TrackedGrid grid = TrackGrid(flow, first, second, /*anchor_second=*/true, {});
  SceneAgreement scene(second.size());
  for (size_t i = 0; i < grid.textured.size(); ++i) {
    scene.AddFlow(grid.textured[i], grid.agrees[i] != 0);
  }
  return scene.IsOneScene();
}

}  // namespace

absl::StatusOr<SceneCuts> FindSceneCuts(FrameSource& source, const std::function<bool()>& goes_on) {
  SceneCuts found;
  cv::Mat former;
  bool former_pair_holds = true;
  int64_t candidate = -1;  // frame k of which only the pair (k - 1, k) has failed
  while (true) {
    if (goes_on && !goes_on()) return absl::CancelledError("interrupted");
    EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source.Next());
    if (const auto* end = std::get_if<EndOfFrames>(&read)) {
      found.frames = end->frame_count;
      break;
    }
    const auto* frame = std::get_if<Frame>(&read);
    if (frame == nullptr) continue;
    cv::Mat grey = SmallGrey(frame->image);
    if (!former.empty()) {
      EGOSIEVE_ASSIGN_OR_RETURN(const bool holds, AreOneScene(former, grey));
      if (holds && candidate >= 0) found.cuts.push_back(candidate);
      candidate = !holds && former_pair_holds ? frame->index : -1;
      former_pair_holds = holds;
    }
    former = std::move(grey);
  }
  if (candidate >= 0) found.cuts.push_back(candidate);
  return found;
}

}  // namespace egosieve::vision
