#include "vision/labelling/forward_links.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/base/status_macros.h"

namespace egosieve::vision {

absl::StatusOr<std::shared_ptr<const FlowPair>> FlowCache::Between(const ExtractedFrame& first,
                                                                   const ExtractedFrame& second) {
  Entry& entry = flows_[first.frame.index];
  if (entry.flow == nullptr || entry.second_index != second.frame.index) {
    EGOSIEVE_ASSIGN_OR_RETURN(FlowPair flow, ComputeFlow(first.grey, second.grey, quality_));
    entry = {second.frame.index, std::make_shared<FlowPair>(std::move(flow))};
  }
  return entry.flow;
}

void FlowCache::Forget(int64_t index) { flows_.erase(flows_.begin(), flows_.lower_bound(index)); }

absl::StatusOr<ForwardLinks> FollowForward(const std::vector<const ExtractedFrame*>& pictures,
                                           const FlowGridOptions& options, FlowCache& flows) {
  ForwardLinks forward;
  const cv::Mat& first = pictures[0]->grey;
  if (!IsLargeEnoughForFlow(first.size())) return forward;
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const FlowPair> flow,
                            flows.Between(*pictures[0], *pictures[1]));
  const auto count = [&](int pixels) {
    return (pixels - options.stride_pixels / 2 + options.stride_pixels - 1) / options.stride_pixels;
  };
  forward.nodes = cv::Size(count(first.cols), count(first.rows));
  TrackedGrid grid = TrackGrid(*flow, first, pictures[1]->grey, /*anchor_second=*/false, options);
  forward.links = std::move(grid.pairs);
  forward.is_textured = std::move(grid.is_textured);
  for (size_t k = 1; k + 1 < pictures.size(); ++k) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const FlowPair> next,
                              flows.Between(*pictures[k], *pictures[k + 1]));
    size_t kept = 0;
    for (size_t i = 0; i < forward.links.size(); ++i) {
      PointPair link = forward.links[i];
      const cv::Point2f at(static_cast<float>(link.x2), static_cast<float>(link.y2));
      const std::optional<cv::Point2f> there =
          FollowFlow(next->forward, next->backward, at, options);
      if (!there) continue;
      link.x2 = there->x;
      link.y2 = there->y;
      forward.is_textured[kept] = forward.is_textured[i];
      forward.links[kept++] = link;
    }
    forward.links.resize(kept);
    forward.is_textured.resize(kept);
  }
  const auto textured = std::count(forward.is_textured.begin(), forward.is_textured.end(), 1);
  forward.followed_share = static_cast<double>(textured) /
                           static_cast<double>(std::max<int64_t>(grid.textured_count, 1));
  return forward;
}

}  // namespace egosieve::vision
