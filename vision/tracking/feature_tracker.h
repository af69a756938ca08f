// Features chained from frame to frame by their matches, so that evidence has a memory.
//
// Every feature of the current frame has a track: the one of the feature that it was matched to in
// the frame before, or a new one. Chaining matches is free of drift in position (each place is a
// detection of its own), but may change over from one scene point to a similar one little by
// little. Against that the descriptor is compared with the track's reference, its first appearance,
// or the one after which `reference_frames` have passed (a scene point's look changes as it comes
// nearer):
//
//   |a - a_ref| > max_descriptor_distance:  the track ends, a new one begins                  (FT1)
//
// Matches must be one to one (mutual). A frame index that is not `frame_step` beyond the last one,
// a dropped frame for instance, ends all tracks. Memory is bounded by the features of one frame,
// about 300 bytes each. Cost: linear in the features. state() is all there is: a tracker restored
// from it goes on bit for bit.
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
  // Euclidean, of 8-bit SIFT descriptors, whose length is about 512; positive.
  double max_descriptor_distance = 350;
  int reference_frames = 16;  // after which the reference is renewed; positive
  int frame_step = 1;         // from one frame of a chain to the next; positive

  absl::Status Validate() const;
};

using SiftDescriptor = std::array<uint8_t, kSiftDescriptorBytes>;

struct FeatureTrackerState {
  int64_t frame_index = -1;  // of the last frame; -1: none yet
  int64_t next_id = 0;
  std::vector<Track> tracks;               // one a feature of the last frame, in its order
  std::vector<SiftDescriptor> references;  // one a track
  std::vector<int32_t> reference_ages;     // frames since the reference was taken
};

class FeatureTracker {
 public:
  static absl::StatusOr<FeatureTracker> Create(const FeatureTrackerOptions& options);

  // matches: from the last frame's features (first) to this one's (second); not read where
  // frame_index is not `frame_step` beyond the last. InvalidArgument for an index that does not
  // grow, for features that are not whole, or for matches out of range or not one to one; the state
  // is unchanged then.
  absl::Status Advance(int64_t frame_index, const FeatureSet& features,
                       const std::vector<Match>& matches);

  // Ends all tracks: a cut, another image size. Ids go on.
  void EndAll();

  // tracks()[i] belongs to feature i of the last frame.
  const std::vector<Track>& tracks() const { return state_.tracks; }
  const FeatureTrackerState& state() const { return state_; }

  // InvalidArgument where the parts of the state do not belong together.
  absl::Status Restore(FeatureTrackerState state);

 private:
  explicit FeatureTracker(const FeatureTrackerOptions& options) : options_(options) {}

  FeatureTrackerOptions options_;
  FeatureTrackerState state_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRACKING_FEATURE_TRACKER_H_
