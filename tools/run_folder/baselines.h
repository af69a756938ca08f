// How far apart a run's pictures lie, from its lines.
//
//   followed    matches / features: places of a grid that flow found again, those without texture
//               among them, by places with texture. Where flow does not hold, features and their
//               matches are added, and the ratio falls
//   far apart   a pair with followed < 0.7
//   sparse      a run in which a tenth of the pairs or more lie far apart: what moves little or is
//               small is missed there
//
// On davis-train (10 clips) and on synthetic drives at 10 frames a second, no pair lies far apart.
// Of every twelfth picture, 4 of 5 pairs of lucia, 5 of 6 of bus and 6 of 7 of stroller do.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_BASELINES_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_BASELINES_H_

#include <cstdint>
#include <string>

#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_description.h"

namespace egosieve::tools {

class Baselines {
 public:
  // Of a run that does not begin with flow (--features), nothing is known.
  explicit Baselines(const RunDescription& description);

  void Add(const FrameLine& line);

  int64_t far_apart() const { return far_apart_; }
  // One sentence where the run is sparse, else empty.
  std::string Describe() const;

 private:
  bool by_flow_;
  int64_t pairs_ = 0, far_apart_ = 0;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_BASELINES_H_
