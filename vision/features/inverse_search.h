// Dense flow by inverse search (DIS), from coarse to fine. Every patch is searched for, starting
// from the displacements of the coarser level and of its neighbours; then the displacements of the
// patches are averaged, and the field is refined.
//
//   f(x) = sum_k w_k u_k / sum_k w_k,  w_k = 1 / max(1, |d_k(x)|)   patches k that hold x  (IS1)
//
// with d_k of flow_patch.h. A patch starts from the flow of the coarser level. It takes over the
// displacement of a neighbour where its E is lower: of those above and left in a first pass, of
// those below and right in a second. Then it is aligned. The rows of patches are searched in 8
// stripes, and nothing is taken over between stripes. (IS1) is refined variationally
// (flow_refinement.h).
//
// Cost: linear in the pixels of the finest level. Reference: Kroeger, Timofte, Dai & Van Gool, Fast
// optical flow using dense inverse search (ECCV 2016).
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/features/flow_patch.h"

namespace egosieve::vision {

struct InverseSearchOptions {
  int finest_level = 1;  // of the pyramid, where level k is reduced by 2^k; not negative
  int patch_stride = 3;  // pixels from patch to patch; 1 to 8
  int refinements = 2;   // rounds of refinement at each level; not negative
};

// A picture at the levels of the search, the finest first.
class SearchPyramid {
 public:
  struct Level {
    cv::Mat1b grey;
    FlowPicture patches;  // of grey
  };

  // picture: CV_8UC1, at least kFlowPatchSide pixels in each direction. Levels that would be smaller
  // are left out.
  SearchPyramid(const cv::Mat& picture, int finest_level);

  const std::vector<Level>& levels() const { return levels_; }
  cv::Size picture_size() const { return picture_size_; }
  int finest_level() const { return finest_level_; }

 private:
  cv::Size picture_size_;
  int finest_level_;
  std::vector<Level> levels_;
};

// Returns the flow from `from` to `to`: CV_32FC2, pixels of the picture. Both must be of pictures
// of one size and have the finest level of the options.
cv::Mat SearchFlow(const SearchPyramid& from, const SearchPyramid& to,
                   const InverseSearchOptions& options);

}  // namespace egosieve::vision
