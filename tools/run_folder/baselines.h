// How far apart a run's pictures lie, from its lines.
//
//   followed    matches / features: places of a grid that flow found again, those without texture
//               among them, by places with texture. Where flow does not hold, features and their
//               matches are added, and the ratio falls
//   far apart   a pair with followed < 0.7
//   sparse      a run in which a tenth of the pairs or more lie far apart: what moves little or is
//               small is missed there
//   thinned     the numbers in the names of a run's pictures (at least kLeastNames) all go up by
//               the same step from 2 to kLargestStep: pictures chosen from a video, which flow may
//               still follow while it no longer sees what moves slowly
//
// On davis-train (10 clips) and on synthetic drives at 10 frames per second, no pair lies far
// apart. Of every sixth picture of lucia none does, as on the roads of KITTI at 10 frames per
// second. Of every twelfth picture, 4 of 5 pairs of lucia, 5 of 6 of bus and 6 of 7 of stroller do.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_BASELINES_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_BASELINES_H_

#include <cstdint>
#include <string>

#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_description.h"

namespace egosieve::tools {

inline constexpr int64_t kLeastNames = 4, kLargestStep = 30;

class Baselines {
 public:
  // Of a run that does not begin with flow (--features), nothing is known.
  explicit Baselines(const RunDescription& description);

  void Add(const FrameLine& line);

  int64_t far_apart() const { return far_apart_; }
  // One sentence where the run is sparse or thinned, else empty.
  std::string Describe() const;

 private:
  void AddName(const FrameLine& line);
  bool IsThinned() const;

  bool by_flow_;
  int64_t pairs_ = 0, far_apart_ = 0;
  int64_t names_ = 0, last_number_ = 0, last_index_ = 0;
  int64_t step_ = 0;  // of the numbers, by frame; 0: not known or not the same for all
  std::string first_name_, second_name_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_BASELINES_H_
