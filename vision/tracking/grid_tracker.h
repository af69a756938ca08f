// Tracks that end in every node of a regular grid, from dense flow between consecutive frames: the
// grid is seeded anew in each frame, and every node inherits the past of the place that it came
// from.
//
//   x_(t-1) = x_t + b(x_t)                 a link: checked flow from t to t - 1; flow_grid.h
//   x_(t-k) = x_(t-1) + o_(k-1)(x_(t-1)),  o_k = places[k] - places[0] of frame t - 1        (GT1)
//
// o is read between the four nodes around x_(t-1), bilinearly, as long as they moved alike: back to
// the first k where their steps places[k] - places[k - 1] differ by more than `agreement_floor +
// agreement_slope |step|`. From there on, and so at the edge of an object, the nearest is read. A
// past ends where it leaves the image, half a node beside one that did not.
// Drift is guarded by the check of each link; a node without a link is a birth.
//
// The nearest node is the parent. Of several children the one nearest to it keeps its id; the
// others (the image expands, driving forward) get new ids. Cost: 16 reads of four a node, about 8
// ms for 18600 nodes. Memory is bounded by the grid, about 160 bytes a node. state() is all there
// is: a tracker restored from it goes on bit for bit.
#ifndef EGOSIEVE_VISION_TRACKING_GRID_TRACKER_H_
#define EGOSIEVE_VISION_TRACKING_GRID_TRACKER_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/geometry/point_pair.h"
#include "vision/tracking/track.h"

namespace egosieve::vision {

// The grid of an image, and the index of the node nearest to a place; nodes: not empty.
cv::Size NodesOf(cv::Size image, int stride_pixels);
int64_t NearestNode(cv::Point2f place, cv::Size nodes, int stride_pixels);

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
  std::vector<Track> tracks;  // nodes.area() of them, row by row
};

class GridTracker {
 public:
  static absl::StatusOr<GridTracker> Create(const GridTrackerOptions& options);

  // links: from the last frame (1) to this one (2), which is `frame_step` later; their ends are
  // nodes of the grid, each at most once, as TrackGrid with anchor_second has them. Not read where
  // frame_index is another, or the image's size: all tracks are born then. InvalidArgument for an
  // index that does not grow, an empty size, and for links whose end is no node or whose beginning
  // is outside the image; the state is unchanged then.
  absl::Status Advance(int64_t frame_index, cv::Size image_size,
                       const std::vector<PointPair>& links);

  // Ends all tracks: a cut. Ids go on.
  void EndAll();

  const std::vector<Track>& tracks() const { return state_.tracks; }
  const GridTrackerState& state() const { return state_; }
  // InvalidArgument where the parts of the state do not belong together.
  absl::Status Restore(GridTrackerState state);

 private:
  explicit GridTracker(const GridTrackerOptions& options) : options_(options) {}

  // Gives the nodes of `next` that links end in their past, and ids to the heirs.
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

#endif  // EGOSIEVE_VISION_TRACKING_GRID_TRACKER_H_
