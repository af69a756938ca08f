// Masks as run lengths, in the common format of COCO and MOTS (pycocotools' maskApi.c).
//
//   runs   lengths of the runs of equal pixels down the columns, left to right; the first is of
//          pixels that are 0, and may have length 0                                          (RU1)
//   text   x_i = run_i for i <= 2, else run_i - run_(i-2); each x in groups of five bits, least
//          significant first, one character per group: 48 + bits, + 32 if more follow. Bit 4 of the
//          last group is the sign                                                            (RU2)
//
// Reference: Lin et al., "Microsoft COCO: Common Objects in Context", ECCV 2014, and its API.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace egosieve::tools {

// (RU1); a pixel is 1 if it is not 0.
std::vector<int64_t> RunLengths(const cv::Mat1b& mask);

// (RU2)
std::string RunLengthText(const std::vector<int64_t>& runs);

}  // namespace egosieve::tools
