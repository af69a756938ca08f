#include "vision/labelling/pair_motions.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "kernels/base/status_macros.h"
#include "vision/geometry/point_pair.h"
#include "vision/image/node_grid.h"
#include "vision/labelling/stopwatch.h"

namespace egosieve::vision {
namespace {

constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();

bool IsKnown(cv::Point2f place) { return std::isfinite(place.x); }

}  // namespace

PatternPlaces::PatternPlaces(const FixedPattern* pattern, const cv::Mat& grey) {
  if (pattern == nullptr) return;
  cv::Mat1b reduced = ReducedPicture(grey);
  // A picture reduced twice may differ by a row from one reduced once.
  const cv::Size off = reduced.size() - pattern->size();
  if (std::max(std::abs(off.width), std::abs(off.height)) > 1) return;
  if (reduced.size() != pattern->size()) {
    cv::resize(reduced, reduced, pattern->size(), 0.0, 0.0, cv::INTER_AREA);
  }
  agreeing_ = pattern->Agreeing(SmoothPicture(reduced));
  scale_ = static_cast<double>(reduced.cols) / grey.cols;
}

bool PatternPlaces::Contain(cv::Point2f place) const {
  if (agreeing_.empty()) return false;
  const int column = std::clamp(cvRound((place.x + 0.5) * scale_ - 0.5), 0, agreeing_.cols - 1);
  const int row = std::clamp(cvRound((place.y + 0.5) * scale_ - 0.5), 0, agreeing_.rows - 1);
  return agreeing_(row, column) != 0;
}

const PatternPlaces& PairMotions::FixedIn(const ExtractedFrame& picture) {
  const auto [places, is_new] = fixed_.try_emplace(picture.frame.index);
  if (is_new) places->second = PatternPlaces(pattern_.get(), picture.grey);
  return places->second;
}

absl::StatusOr<GridLinks> PairMotions::Follow(const Pictures& pictures) {
  GridLinks links;
  const cv::Mat& first = pictures[0]->grey;
  if (!IsLargeEnoughForFlow(first.size())) return links;
  Stopwatch watch;
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const TrackedGrid> tracked,
                            flows_->Grid(*pictures[0], *pictures[1], /*anchor_second=*/false));
  std::vector<std::shared_ptr<const FlowPair>> further;
  for (size_t k = 1; k + 1 < pictures.size(); ++k) {
    EGOSIEVE_ASSIGN_OR_RETURN(further.emplace_back(),
                              flows_->Between(*pictures[k], *pictures[k + 1]));
  }
  flow_milliseconds_ += watch.LapMilliseconds();
  const TrackedGrid& grid = *tracked;
  const int stride = options_.stride_pixels;
  links.nodes = NodesOf(first.size(), stride);
  links.near.assign(links.nodes.area(), cv::Point2f(kNowhere, kNowhere));
  links.is_textured.assign(links.nodes.area(), 0);
  int64_t followed = 0;
  for (size_t i = 0; i < grid.pairs.size(); ++i) {
    const PointPair& pair = grid.pairs[i];
    const int64_t node = NodeAt(pair.x1, pair.y1, links.nodes.width, stride);
    links.near[node] = {static_cast<float>(pair.x2), static_cast<float>(pair.y2)};
    links.is_textured[node] = grid.is_textured[i];
    followed += grid.is_textured[i];
  }
  links.followed_share = static_cast<double>(followed) /
                         static_cast<double>(std::max<size_t>(grid.textured.size(), 1));
  links.far = links.near;
  links.last = 1;
  const double least = motion_options_.travel.IsOfVehicle() ? 0.0 : kFollowsFar;
  for (const auto& next : further) {
    std::vector<cv::Point2f> places = links.far;
    int64_t far = 0;
    for (size_t n = 0; n < places.size(); ++n) {
      if (!IsKnown(places[n])) continue;
      places[n] = FollowFlow(next->forward, next->backward, places[n])
                      .value_or(cv::Point2f(kNowhere, kNowhere));
      far += links.is_textured[n] != 0 && IsKnown(places[n]);
    }
    if (static_cast<double>(far) < least * static_cast<double>(followed)) break;
    links.far = std::move(places);
    ++links.last;
  }
  return links;
}

TwoViewMotion PairMotions::Along(const ExtractedFrame& first, const ExtractedFrame& last,
                                 const GridLinks& links, const std::vector<cv::Point2f>& places,
                                 const Pinhole& camera, absl::Span<const float> moved) {
  const auto [known, is_new] = motions_.try_emplace({first.frame.index, last.frame.index});
  if (!is_new) return known->second;
  const PatternPlaces& fixed = FixedIn(first);
  std::vector<PointPair> pairs;
  std::vector<float> moved_before;
  for (size_t n = 0; n < places.size(); ++n) {
    if (links.is_textured[n] == 0 || !IsKnown(places[n])) continue;
    const cv::Point2f node =
        PlaceOfNode(static_cast<int>(n), links.nodes.width, options_.stride_pixels);
    if (fixed.Contain(node)) continue;
    pairs.push_back({node.x, node.y, places[n].x, places[n].y});
    if (moved.size() == places.size()) moved_before.push_back(moved[n]);
  }
  known->second = EstimateOnDrive(pairs, camera, motion_options_, moved_before);
  return known->second;
}

absl::StatusOr<TwoViewMotion> PairMotions::Between(const ExtractedFrame& first,
                                                   const ExtractedFrame& second,
                                                   const Pinhole& camera,
                                                   absl::Span<const float> moved) {
  if (const TwoViewMotion* known = Find(first.frame.index, second.frame.index)) return *known;
  EGOSIEVE_ASSIGN_OR_RETURN(const GridLinks links, Follow({&first, &second}));
  return Along(first, second, links, links.near, camera, moved);
}

const TwoViewMotion* PairMotions::Find(int64_t first, int64_t second) const {
  const auto known = motions_.find({first, second});
  return known == motions_.end() ? nullptr : &known->second;
}

std::vector<KnownMotion> PairMotions::known() const {
  std::vector<KnownMotion> known;
  for (const auto& [indices, motion] : motions_) {
    known.push_back({indices.first, indices.second, motion});
  }
  return known;
}

void PairMotions::Restore(const std::vector<KnownMotion>& known) {
  for (const KnownMotion& pair : known) motions_[{pair.first, pair.second}] = pair.motion;
}

void PairMotions::Forget(int64_t index, int64_t oldest) {
  flows_->Forget(index);
  fixed_.erase(fixed_.begin(), fixed_.lower_bound(index));
  std::erase_if(motions_, [&](const auto& known) {
    const auto [first, last] = known.first;
    return first < oldest || (first < index && last > index);
  });
}

}  // namespace egosieve::vision
