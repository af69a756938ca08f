#include "vision/tracking/grid_tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/image/bilinear.h"
#include "vision/image/inside.h"
#include "vision/image/node_grid.h"

namespace egosieve::vision {
namespace {

// The length of history that all four tracks have: the least of their lengths.
int64_t CommonLength(const Track* const (&around)[4]) {
  int64_t length = around[0]->length;
  for (const Track* track : around) length = std::min(length, track->length);
  return length;
}

cv::Point2f Offset(const Track& track, int k) { return track.places[k] - track.places[0]; }

cv::Point2f Step(const Track& track, int k) { return track.places[k] - track.places[k - 1]; }

}  // namespace

absl::Status GridTrackerOptions::Validate() const {
  return kernels::CheckOptions({
      {"stride_pixels", stride_pixels, stride_pixels >= 1, "be positive"},
      {"frame_step", frame_step, frame_step >= 1, "be positive"},
      {"agreement_floor", agreement_floor, kernels::IsPositive(agreement_floor), "be positive"},
      {"agreement_slope", agreement_slope, kernels::IsNotNegative(agreement_slope),
       "not be negative"},
  });
}

absl::StatusOr<GridTracker> GridTracker::Create(const GridTrackerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  return GridTracker(options);
}

Track GridTracker::Inherit(cv::Point2f node, cv::Point2f before, cv::Size image_size) const {
  const int stride = options_.stride_pixels;
  const auto among = [&](float pixels, int count) {  // the nodes
    return AroundClamped<AtLast::kAlone>((pixels - stride / 2) / static_cast<float>(stride), count);
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
  const Track& nearest = state_.tracks[NearestNode(before, state_.nodes, options_.stride_pixels)];

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
      agree = spread <= options_.agreement_floor + options_.agreement_slope * cv::norm(step);
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

int64_t GridTracker::NodeOf(const PointPair& link, cv::Size nodes) const {
  const int stride = options_.stride_pixels;
  const double column = (link.x2 - stride / 2) / stride, row = (link.y2 - stride / 2) / stride;
  const bool is_node = column == std::floor(column) && row == std::floor(row) && column >= 0 &&
                       row >= 0 && column < nodes.width && row < nodes.height;
  return is_node ? static_cast<int64_t>(row) * nodes.width + static_cast<int64_t>(column) : -1;
}

absl::Status GridTracker::Advance(int64_t frame_index, cv::Size image_size,
                                  const std::vector<PointPair>& links) {
  if (frame_index < 0 || frame_index <= state_.frame_index) {
    return absl::InvalidArgumentError(absl::StrCat("frame ", frame_index, " after frame ",
                                                   state_.frame_index, "; indices must grow"));
  }
  const int stride = options_.stride_pixels;
  GridTrackerState next;
  next.frame_index = frame_index;
  next.next_id = state_.next_id;
  next.nodes = NodesOf(image_size, stride);
  if (next.nodes.width < 1 || next.nodes.height < 1) {
    return absl::InvalidArgumentError(absl::StrCat("an image of ", image_size.width, " x ",
                                                   image_size.height, " has no node of the grid"));
  }
  next.tracks.resize(next.nodes.area());
  for (size_t n = 0; n < next.tracks.size(); ++n) {
    next.tracks[n].length = 1;
    next.tracks[n].places[0] = PlaceOfNode(static_cast<int>(n), next.nodes.width, stride);
  }
  const bool follows = !state_.tracks.empty() &&
                       frame_index == state_.frame_index + options_.frame_step &&
                       next.nodes == state_.nodes;
  if (follows) EGOSIEVE_RETURN_IF_ERROR(Link(image_size, links, next));
  for (Track& track : next.tracks) {
    if (track.id < 0) track.id = next.next_id++;
  }
  state_ = std::move(next);
  return absl::OkStatus();
}

absl::Status GridTracker::Link(cv::Size image_size, const std::vector<PointPair>& links,
                               GridTrackerState& next) const {
  std::vector<int64_t> heirs(state_.tracks.size(), -1);  // by parent
  std::vector<float> distances(state_.tracks.size(), 0.0F);
  for (const PointPair& link : links) {
    const int64_t n = NodeOf(link, next.nodes);
    if (n < 0 || !IsInside(link.x1, link.y1, image_size) || next.tracks[n].length != 1) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the link from (", link.x1, ", ", link.y1, ") to (", link.x2, ", ", link.y2,
          ") must begin in the image and end in a node of the grid that no other ends in"));
    }
    const cv::Point2f before(link.x1, link.y1);
    next.tracks[n] = Inherit(next.tracks[n].places[0], before, image_size);
    const int64_t parent = NearestNode(before, state_.nodes, options_.stride_pixels);
    const cv::Point2f off = before - state_.tracks[parent].places[0];
    const float distance = off.dot(off);
    if (heirs[parent] >= 0 && distances[parent] <= distance) continue;
    heirs[parent] = n;
    distances[parent] = distance;
  }
  for (size_t p = 0; p < heirs.size(); ++p) {
    if (heirs[p] >= 0) next.tracks[heirs[p]].id = state_.tracks[p].id;
  }
  return absl::OkStatus();
}

void GridTracker::EndAll() { state_.tracks.clear(); }

absl::Status GridTracker::Restore(GridTrackerState state) {
  const bool whole =
      state.tracks.empty() || static_cast<int64_t>(state.tracks.size()) == state.nodes.area();
  if (!whole) {
    return absl::InvalidArgumentError(absl::StrCat("grid tracker state has ", state.tracks.size(),
                                                   " tracks for ", state.nodes.area(), " nodes"));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckTracks("grid tracker state", state.tracks, state.next_id));
  state_ = std::move(state);
  return absl::OkStatus();
}

}  // namespace egosieve::vision
