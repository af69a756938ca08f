// Truth as labelled tracks: lines `track,label,frame,x,y` under that header. Label 1 is static,
// labels of 2 or more are movers. Pixels count from 0 and may have fractions. Fields are in any
// order; others are ignored.
#ifndef EGOSIEVE_TOOLS_EVALUATION_TRACK_TRUTH_H_
#define EGOSIEVE_TOOLS_EVALUATION_TRACK_TRUTH_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

struct LabelledPoint {
  int64_t track = 0;
  int label = 1;
  double x = 0.0;  // pixels
  double y = 0.0;

  bool dynamic() const { return label >= 2; }
};

struct TrackTruth {
  std::map<int64_t, std::vector<LabelledPoint>> frames;  // in the order of the file
  int64_t static_points = 0;
  int64_t dynamic_points = 0;
};

// DataLoss, naming the line and its error; FailedPrecondition if there are no points or points of
// only one class.
absl::StatusOr<TrackTruth> ParseTrackTruth(absl::string_view csv);

// The same from a file, named in errors; NotFound.
absl::StatusOr<TrackTruth> ReadTrackTruth(const std::string& path);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_TRACK_TRUTH_H_
