// Chains features from frame to frame by their matches, so that evidence can be accumulated.
//
// Every feature of the current frame has a track: that of its match in the frame before, or a new
// one. Chained matches do not drift in position, since each place is a detection of its own, but
// they may change over gradually to a similar scene point nearby. Therefore the descriptor is
// compared with the track's reference. This is its first descriptor, renewed after
// `reference_frames` frames, since a scene point changes its appearance as it comes nearer:
//
//   |a - a_ref| > max_descriptor_distance:  the track ends, a new one begins                  (FT1)
//
// Matches must be one to one (mutual). If a frame index is not the last one plus `frame_step`, for
// instance after a dropped frame, all tracks end. Memory is bounded by the features of one frame,
// about 300 bytes each. Cost: linear in the features. state() is the complete state: a tracker
// restored from it continues with the same bits.
#ifndef EGOSIEVE_VISION_TRACKING_FEATURE_TRACKER_H_
#define EGOSIEVE_VISION_TRACKING_FEATURE_TRACKER_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/features/feature_set.h"
#include "vision/matching/feature_matcher.h"
#include "vision/tracking/track.h"

namespace egosieve::vision {

struct FeatureTrackerOptions {
  // Euclidean distance of 8-bit SIFT descriptors, whose length is about 512; positive.
  double max_descriptor_distance = 350;
  int reference_frames = 16;  // frames until the reference is renewed; positive
  int frame_step = 1;         // from one frame of a chain to the next; positive

  absl::Status Validate() const;
};

using SiftDescriptor = std::array<uint8_t, kSiftDescriptorBytes>;

struct FeatureTrackerState {
  int64_t frame_index = -1;  // of the last frame; -1: none yet
  int64_t next_id = 0;
  std::vector<Track> tracks;               // one per feature of the last frame, in its order
  std::vector<SiftDescriptor> references;  // one per track
  std::vector<int32_t> reference_ages;     // frames since the reference was taken
};

class FeatureTracker {
 public:
  static absl::StatusOr<FeatureTracker> Create(const FeatureTrackerOptions& options);

  // matches: from the last frame's features (first) to this one's (second); ignored if frame_index
  // is not the last one plus `frame_step`. InvalidArgument for an index that does not increase, for
  // incomplete features, or for matches out of range or not one to one; the state is then
  // unchanged.
  absl::Status Advance(int64_t frame_index, const FeatureSet& features,
                       const std::vector<Match>& matches);

  // Ends all tracks, as after a cut or a change of the image size. Ids continue.
  void EndAll();

  // tracks()[i] belongs to feature i of the last frame.
  const std::vector<Track>& tracks() const { return state_.tracks; }
  const FeatureTrackerState& state() const { return state_; }

  // InvalidArgument if the parts of the state are inconsistent.
  absl::Status Restore(FeatureTrackerState state);

 private:
  explicit FeatureTracker(const FeatureTrackerOptions& options) : options_(options) {}

  FeatureTrackerOptions options_;
  FeatureTrackerState state_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRACKING_FEATURE_TRACKER_H_
