// Real sequences below EGOSIEVE_DATA. The suite takes their first frames; with EGOSIEVE_EVERY_FRAME
// in the environment tests take all, for many minutes.
#ifndef EGOSIEVE_TESTS_VISION_LABELLING_REAL_INPUTS_H_
#define EGOSIEVE_TESTS_VISION_LABELLING_REAL_INPUTS_H_

#include <cstdlib>
#include <string>
#include <vector>

namespace egosieve::vision {

inline bool AllFrames() { return std::getenv("EGOSIEVE_EVERY_FRAME") != nullptr; }

inline std::vector<std::string> RealInputs() {
  return {"davis/car-shadow/frames",        "davis/horsejump-high/frames",
          "davis/bmx-trees/frames",         "davis/cows/frames",
          "kt3dmoseg/Seq005_Clip01/frames", "kt3dmoseg/Seq013_Clip02/frames",
          "kt3dmoseg/Seq028_Clip01/frames", "kitti-residential/frames",
          "highway/solidWhiteRight.mp4",    "highway/vehicle_test_video.mp4"};
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_TESTS_VISION_LABELLING_REAL_INPUTS_H_
