// Tracks that end in the nodes of a regular grid, from dense flow between consecutive frames. The
// grid is placed anew in each frame, and every node inherits the history of the place that it came
// from.
//
//   x_(t-1) = x_t + b(x_t)                 a link: checked flow from t to t - 1; flow_grid.h
//   x_(t-k) = x_(t-1) + o_(k-1)(x_(t-1)),  o_k = places[k] - places[0] of frame t - 1        (GT1)
//
// o is interpolated bilinearly between the four nodes around x_(t-1), as long as they moved alike:
// back to the first k where their steps places[k] - places[k - 1] differ by more than
// `agreement_floor + agreement_slope |step|`. For that k and older places, and so at the edges of
// objects, the nearest node's o is taken. A history ends where it leaves the image, even if that of
// a neighbouring node does not. The check of each link limits drift; a node without a link starts a
// new track.
//
// The nearest node is the parent. Of several children, the one nearest to the parent keeps its id;
// the others get new ids (when driving forward, the image expands and parents have several). Cost:
// 16 interpolations per node. Memory is bounded by the grid, about 160 bytes per node. state() is
// the complete state: a tracker restored from it continues with the same bits.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/geometry/point_pair.h"
#include "vision/tracking/track.h"

namespace egosieve::vision {

struct GridTrackerOptions {
  int stride_pixels = 5;         // of the grid, that of the links; positive
  int frame_step = 1;            // from one frame of a chain to the next; positive
  double agreement_floor = 1.0;  // pixels; positive
  double agreement_slope = 0.1;  // >= 0

  absl::Status Validate() const;
};

struct GridTrackerState {
  int64_t frame_index = -1;  // of the last frame; -1: none yet
  int64_t next_id = 0;
  cv::Size nodes;             // of the grid
  std::vector<Track> tracks;  // nodes.area() tracks, row by row
};

class GridTracker {
 public:
  static absl::StatusOr<GridTracker> Create(const GridTrackerOptions& options);

  // links: from the last frame (1) to this one (2), which must be `frame_step` later. Their ends
  // are nodes of the grid, each at most once, as from TrackGrid with anchor_second. If frame_index
  // or the image's size is another, links are ignored and all tracks start anew. InvalidArgument
  // for an index that does not increase, for an empty size, and for links whose end is no node or
  // whose beginning is outside the image; the state is then unchanged.
  absl::Status Advance(int64_t frame_index, cv::Size image_size,
                       const std::vector<PointPair>& links);

  // Ends all tracks, as after a cut. Ids continue.
  void EndAll();

  const std::vector<Track>& tracks() const { return state_.tracks; }
  const GridTrackerState& state() const { return state_; }
  // InvalidArgument if the parts of the state are inconsistent.
  absl::Status Restore(GridTrackerState state);

 private:
  explicit GridTracker(const GridTrackerOptions& options) : options_(options) {}

  // Gives linked nodes of `next` their history, and each parent's id to its nearest child.
  absl::Status Link(cv::Size image_size, const std::vector<PointPair>& links,
                    GridTrackerState& next) const;
  // (GT1) for a node that came from `before`; a track without an id.
  Track Inherit(cv::Point2f node, cv::Point2f before, cv::Size image_size) const;
  // The node that a link ends in, or -1.
  int64_t NodeOf(const PointPair& link, cv::Size nodes) const;

  GridTrackerOptions options_;
  GridTrackerState state_;
};

}  // namespace egosieve::vision
