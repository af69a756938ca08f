// How far apart the pictures of a run are, judged from its lines.
//
//   followed    matches / features: the grid places that optical flow found again, including places
//               without texture, divided by the places with texture
//   far apart   a pair with followed < 0.7
//   sparse      a run in which a tenth of the pairs or more are far apart: small or slow movers
//               are missed in it
//   thinned     a run whose pictures' names have numbers (at least kLeastNames of them) that all
//               rise by the same step from 2 to kLargestStep: pictures chosen from a video. Flow
//               may still follow them, but slow movers are no longer detected
#pragma once

#include <cstdint>
#include <string>

#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_description.h"

namespace egosieve::tools {

inline constexpr int64_t kLeastNames = 4, kLargestStep = 30;

class Baselines {
 public:
  // A run without flow, of profile paper, gives no statement.
  explicit Baselines(const RunDescription& description);

  void Add(const FrameLine& line);

  int64_t far_apart() const { return far_apart_; }
  // One sentence if the run is sparse or thinned, else empty.
  std::string Describe() const;

 private:
  void AddName(const FrameLine& line);
  bool IsThinned() const;

  bool by_flow_;
  int64_t pairs_ = 0, far_apart_ = 0;
  int64_t names_ = 0, last_number_ = 0, last_index_ = 0;
  int64_t step_ = 0;  // step of the numbers per frame; 0: unknown, or not constant
  std::string first_name_, second_name_;
};

}  // namespace egosieve::tools
