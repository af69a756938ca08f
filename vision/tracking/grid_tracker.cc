#include "vision/tracking/grid_tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "vision/image/bilinear.h"
#include "vision/image/inside.h"
#include "vision/image/node_grid.h"

namespace egosieve::vision {
namespace {

constexpr double kAgreementFloor = 1.0, kAgreementSlope = 0.1;  // the former in pixels

// The length of history that all four tracks have: the least of their lengths.
int64_t CommonLength(const Track* const (&around)[4]) {
  int64_t length = around[0]->length;
  for (const Track* track : around) length = std::min(length, track->length);
  return length;
}

cv::Point2f Offset(const Track& track, int k) { return track.places[k] - track.places[0]; }

cv::Point2f Step(const Track& track, int k) { return track.places[k] - track.places[k - 1]; }

}  // namespace

Track GridTracker::Inherit(cv::Point2f node, cv::Point2f before, cv::Size image_size) const {
  const auto among = [&](float pixels, int count) {  // the nodes
    return AroundClamped<AtLast::kAlone>((pixels - stride_ / 2) / static_cast<float>(stride_),
                                         count);
  };
  const Around<float> x = among(before.x, state_.nodes.width);
  const Around<float> y = among(before.y, state_.nodes.height);
  const auto at = [&](int row, int column) {
    return &state_.tracks[static_cast<size_t>(row) * state_.nodes.width + column];
  };
  const Track* const around[4] = {at(y.low, x.low), at(y.low, x.high), at(y.high, x.low),
                                  at(y.high, x.high)};
  const float weights[4] = {(1 - x.share) * (1 - y.share), x.share * (1 - y.share),
                            (1 - x.share) * y.share, x.share * y.share};
  const Track& nearest = state_.tracks[NearestNode(before, state_.nodes, stride_)];

  Track track;
  track.parent_id = nearest.id;
  track.places[0] = node;
  track.places[1] = before;
  const int64_t common = CommonLength(around);
  bool agree = true;
  track.length = 2;
  for (int k = 1; k + 1 < kTrackHistory && k < nearest.length; ++k) {
    cv::Point2f offset = Offset(nearest, k);
    agree = agree && k < common;
    if (agree) {
      cv::Point2f mean(0, 0);
      const cv::Point2f step = Step(nearest, k);
      double spread = 0.0;
      for (int n = 0; n < 4; ++n) {
        mean += weights[n] * Offset(*around[n], k);
        const cv::Point2f other = Step(*around[n], k);
        spread = std::max(spread, cv::norm(other - step));
      }
      agree = spread <= kAgreementFloor + kAgreementSlope * cv::norm(step);
      if (agree) offset = mean;
    }
    const cv::Point2f place = before + offset;
    if (!IsInside(place.x, place.y, image_size)) break;
    track.places[k + 1] = place;
    ++track.length;
  }
  if (track.length == kTrackHistory) track.length = nearest.length + 1;
  return track;
}

void GridTracker::Advance(int64_t frame_index, cv::Size image_size,
                          const std::vector<PointPair>& links) {
  GridTrackerState next;
  next.frame_index = frame_index;
  next.next_id = state_.next_id;
  next.nodes = NodesOf(image_size, stride_);
  next.tracks.resize(next.nodes.area());
  for (size_t n = 0; n < next.tracks.size(); ++n) {
    next.tracks[n].length = 1;
    next.tracks[n].places[0] = PlaceOfNode(static_cast<int>(n), next.nodes.width, stride_);
  }
  const bool follows =
      !state_.tracks.empty() && frame_index == state_.frame_index + 1 && next.nodes == state_.nodes;
  if (follows) Link(image_size, links, next);
  for (Track& track : next.tracks) {
    if (track.id < 0) track.id = next.next_id++;
  }
  state_ = std::move(next);
}

void GridTracker::Link(cv::Size image_size, const std::vector<PointPair>& links,
                       GridTrackerState& next) const {
  std::vector<int64_t> heirs(state_.tracks.size(), -1);  // by parent
  std::vector<float> distances(state_.tracks.size(), 0.0F);
  for (const PointPair& link : links) {
    const int64_t n = NodeAt(link.x2, link.y2, next.nodes.width, stride_);
    const cv::Point2f before(link.x1, link.y1);
    next.tracks[n] = Inherit(next.tracks[n].places[0], before, image_size);
    const int64_t parent = NearestNode(before, state_.nodes, stride_);
    const cv::Point2f off = before - state_.tracks[parent].places[0];
    const float distance = off.dot(off);
    if (heirs[parent] >= 0 && distances[parent] <= distance) continue;
    heirs[parent] = n;
    distances[parent] = distance;
  }
  for (size_t p = 0; p < heirs.size(); ++p) {
    if (heirs[p] >= 0) next.tracks[heirs[p]].id = state_.tracks[p].id;
  }
}

void GridTracker::EndAll() { state_.tracks.clear(); }

absl::Status GridTracker::Restore(GridTrackerState state) {
  const bool whole =
      state.tracks.empty() || static_cast<int64_t>(state.tracks.size()) == state.nodes.area();
  if (!whole) {
    return absl::InvalidArgumentError(absl::StrCat("grid tracker state has ", state.tracks.size(),
                                                   " tracks for ", state.nodes.area(), " nodes"));
  }
  for (const Track& track : state.tracks) {
    if (track.id >= 0 && track.id < state.next_id && track.length >= 1) continue;
    return absl::InvalidArgumentError(absl::StrCat("grid tracker state has a track ", track.id,
                                                   " of length ", track.length, "; the next id is ",
                                                   state.next_id));
  }
  state_ = std::move(state);
  return absl::OkStatus();
}

}  // namespace egosieve::vision
