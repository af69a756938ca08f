// A sequence of frames with truth to score features against: one of a suite's
// (tools/suite/sequences.h). Of labelled tracks, "track,label,frame,x,y", frame k is the one whose
// name ends in k; frames follow each other in natural order.
#ifndef EGOSIEVE_TOOLS_EVALUATE_FEATURES_FEATURE_SEQUENCE_H_
#define EGOSIEVE_TOOLS_EVALUATE_FEATURES_FEATURE_SEQUENCE_H_

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

// Those of the suite in `folder`, in natural order of their names. NotFound where there is none.
absl::StatusOr<std::vector<FeatureSequence>> FindFeatureSequences(const std::string& folder);

// What a sequence's frames are scored against: masks or tracks.
struct FeatureTruth {
  std::map<int64_t, std::string> masks;       // by frame index
  std::vector<vision::LabelledTrack> tracks;  // used where there are no masks

  bool has_tracks() const { return !tracks.empty(); }
};

absl::StatusOr<FeatureTruth> ReadFeatureTruth(const FeatureSequence& sequence);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_FEATURES_FEATURE_SEQUENCE_H_
