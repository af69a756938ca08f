// Tracks that end in the nodes of a regular grid, from dense flow between consecutive frames. The
// grid is placed anew in each frame, and every node inherits the history of the place that it came
// from.
//
//   x_(t-1) = x_t + b(x_t)                 a link: checked flow from t to t - 1; flow_grid.h
//   x_(t-k) = x_(t-1) + o_(k-1)(x_(t-1)),  o_k = places[k] - places[0] of frame t - 1        (GT1)
//
// o is interpolated bilinearly between the four nodes around x_(t-1), as long as they moved alike:
// back to the first k where their steps places[k] - places[k - 1] differ by more than
// kAgreementFloor + kAgreementSlope |step|. For that k and older places, and so at the edges of
// objects, the nearest node's o is taken. A history ends where it leaves the image, even if that of
// a neighbouring node does not. The check of each link limits drift; a node without a link starts a
// new track.
//
// The nearest node is the parent. Of several children, the one nearest to the parent keeps its id;
// the others get new ids (when driving forward, the image expands and parents have several). Cost:
// 16 interpolations per node. Memory is bounded by the grid, about 160 bytes per node. state() is
// the complete state: a tracker restored from it continues with the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// One scene point followed through consecutive frames. A track may have any length; its places in
// the last kTrackHistory frames are kept.
inline constexpr int kTrackHistory = 16;

struct Track {
  int64_t id = -1;         // unique within a drive
  int64_t parent_id = -1;  // id in the frame before, another track's after a split; -1: none
  int64_t length = 0;      // frames since its start, including the current one
  std::array<cv::Point2f, kTrackHistory> places;  // [k]: k frames before the current one, pixels

  // Whether places[k] exists.
  bool Reaches(int k) const { return k >= 0 && k < kTrackHistory && k < length; }
};

struct GridTrackerState {
  int64_t frame_index = -1;  // of the last frame; -1: none yet
  int64_t next_id = 0;
  cv::Size nodes;             // of the grid
  std::vector<Track> tracks;  // nodes.area() tracks, row by row
};

class GridTracker {
 public:
  // stride_pixels: of the grid, that of the links; positive.
  explicit GridTracker(int stride_pixels) : stride_(stride_pixels) {}

  // links: from the last frame (1), inside the image, to this one (2), whose index is the next.
  // Their ends are nodes of the grid, each at most once, as from TrackGrid with anchor_second. If
  // the index is a later one or the image's size another, links are ignored and all tracks start
  // anew.
  void Advance(int64_t frame_index, cv::Size image_size, const std::vector<PointPair>& links);

  // Ends all tracks, as after a cut. Ids continue.
  void EndAll();

  const std::vector<Track>& tracks() const { return state_.tracks; }
  const GridTrackerState& state() const { return state_; }
  // InvalidArgument if the parts of the state are inconsistent.
  absl::Status Restore(GridTrackerState state);

 private:
  // Gives linked nodes of `next` their history, and each parent's id to its nearest child.
  void Link(cv::Size image_size, const std::vector<PointPair>& links, GridTrackerState& next) const;
  // (GT1) for a node that came from `before`; a track without an id.
  Track Inherit(cv::Point2f node, cv::Point2f before, cv::Size image_size) const;

  int stride_;
  GridTrackerState state_;
};

}  // namespace egosieve::vision
