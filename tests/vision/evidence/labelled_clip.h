// Clips with labelled point tracks (KT3DMoSeg; see the data's README): the clip's own features
// tracked by the library, from which motion is estimated, and beside them the labelled tracks, at
// which evidence is scored.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/tracking/track.h"

namespace egosieve::vision {

struct LabelledClip {
  struct Frame {
    std::vector<Track> features;  // SIFT and corners, chained by their matches
    std::vector<Track> labelled;  // ids as in the file
    std::vector<bool> moving;     // one a labelled track
  };
  std::string name;
  cv::Size size;
  std::vector<Frame> frames;
};

// directory/{frames/%06d.png, tracks.csv}; the first `max_frames`, `features` asked for in each (0:
// by the image's area).
absl::StatusOr<LabelledClip> LoadLabelledClip(const std::string& directory, int max_frames = 1000);

// Area under the ROC curve of positives above negatives, ties counting half; 0.5 without either.
double AreaUnderCurve(const std::vector<double>& positives, const std::vector<double>& negatives);

}  // namespace egosieve::vision
