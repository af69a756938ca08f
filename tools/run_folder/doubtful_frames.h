// Which frames of a run are unreliable, and from which nothing was learnt, and why.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/run_folder/frame_line.h"

namespace egosieve::tools {

// Why the frame is unreliable: its labels are, or its map expects a small overlap with what moves.
// Empty if it is reliable.
std::string DoubtOf(const FrameLine& line);

// Frames by the kind of their reason.
class ReasonKinds {
 public:
  struct Kind {
    std::string first;  // the reason of the first frame
    std::vector<int64_t> frames;
  };
  void Add(const std::string& reason, int64_t frame);
  std::vector<Kind> MostFrequentFirst() const;

 private:
  std::map<std::string, Kind> kinds_;  // by WithoutNumbers
};

class DoubtfulFrames {
 public:
  void Add(const FrameLine& line);

  int64_t count() const { return count_; }
  // "12 of 62 frames are unreliable, most often: ..."; empty if there are none.
  std::string Sentence() const;

  // Empty if the model learnt from half of the frames or more: "only 2 of 30 frames were learnt
  // from, the others most often not because: ...". Not counted are frames that could not be read,
  // the same picture again, and a drive's first frames, which have no picture before them.
  std::string TooFewLearnt() const;

 private:
  int64_t frames_ = 0, count_ = 0;
  ReasonKinds doubts_;
  int64_t learnt_ = 0, not_learnt_ = 0;
  ReasonKinds not_learnt_reasons_;
};

}  // namespace egosieve::tools
