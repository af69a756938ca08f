// A sequence of frames with truth for scoring features: one of a suite's (tools/suite/sequences.h).
// In labelled tracks, "track,label,frame,x,y", frame k is the frame whose name ends in k. Frames
// are in natural order.
#ifndef EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_FEATURE_SEQUENCE_H_
#define EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_FEATURE_SEQUENCE_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/labelling/feature_evaluation.h"

namespace egosieve::tools {

struct FeatureSequence {
  std::string name;    // for the table: the folder's, below the suite
  std::string frames;  // an input of vision/frame/frame_source.h
  std::string truth;   // a folder of masks or a file of tracks
};

// The sequences of the suite in `folder`, in natural order of their names. NotFound if there is
// none.
absl::StatusOr<std::vector<FeatureSequence>> FindFeatureSequences(const std::string& folder);

// Truth for a sequence's frames: masks or tracks.
struct FeatureTruth {
  std::map<int64_t, std::string> masks;       // by frame index
  std::vector<vision::LabelledTrack> tracks;  // used if there are no masks

  bool has_tracks() const { return !tracks.empty(); }
};

absl::StatusOr<FeatureTruth> ReadFeatureTruth(const FeatureSequence& sequence);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_FEATURE_SEQUENCE_H_
