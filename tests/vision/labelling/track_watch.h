// What must hold of a labeller's tracks and evidence after every frame, whatever it was shown.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <set>
#include <vector>

#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/labelling/labeller_state.h"
#include "vision/tracking/grid_tracker.h"

namespace egosieve::vision {

class TrackWatch {
 public:
  // After every frame that the labeller was given, in order; none of them twice the same picture.
  //
  //   ids      unique, none given twice in a drive; parents are tracks of the picture before
  //   lengths  no track is older than the pictures since the last frame without labels
  //   places   those of the history are inside the picture
  //   memory   tracks and sums no more than nodes and features, poses and images no more than gaps
  void Check(const LabelledFrame& labels, const LabellerState& state);

 private:
  struct Ids {
    std::set<int64_t> last;  // of the picture before
    int64_t next = 0;
  };
  void CheckTracks(const std::vector<Track>& tracks, int64_t next_id, cv::Size size, Ids& ids);

  Ids grid_;
  int64_t pictures_ = 0;  // in a row, since the last frame that nothing leads to
  int64_t begin_ = 0;     // that frame
};

}  // namespace egosieve::vision
