// Dense flow by inverse search (DIS): coarse to fine, every patch is searched for from where the
// coarser level and its neighbours lead, then the patches' displacements are averaged.
//
//   d_i = J(x_i + u) - I(x_i)                                       8 x 8 pixels of a patch
//   E(u) = sum (d_i - mean d)^2                                                            (IS1)
//   u <- u - H^-1 sum (g_i - mean g) d_i,  g gradient of I,  H = sum g_i g_i^T             (IS2)
//   f(x) = sum_k w_k u_k / sum_k w_k,  w_k = 1 / max(1, |d_k(x)|)   patches k that hold x  (IS3)
//
// A patch begins from the flow of the coarser level, takes over the displacement of a neighbour
// where its E is less, from above and left in a first pass, from below and right in a second, and
// takes steps (IS2), the last where E no longer falls. g is Sobel's sum, eight times the gradient
// per pixel: whole steps would follow the pictures' noise. A descent that leaves by more than a
// patch's side is undone. The patches' rows are searched in 8 stripes, across which nothing is
// taken over. What (IS3) gives is refined variationally by OpenCV.
//
// Every sum is in the order of OpenCV's cv::DISOpticalFlow on x86-64, so that flow has its bytes;
// in registers of 8 floats instead of 4, and with what belongs to a picture made once for both
// directions, it takes less time.
//
// Gradients belong to I, so H is computed once (inverse compositional alignment). Cost: linear in
// the pixels of the finest level. Reference: Kroeger, Timofte, Dai & Van Gool, Fast optical flow
// using dense inverse search (ECCV 2016).
#ifndef EGOSIEVE_VISION_FEATURES_INVERSE_SEARCH_H_
#define EGOSIEVE_VISION_FEATURES_INVERSE_SEARCH_H_

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

struct InverseSearchOptions {
  int finest_level = 1;  // of the pyramid, where level k is reduced by 2^k; not negative
  int patch_stride = 3;  // pixels from patch to patch; from 1 to 8
  int most_steps = 12;   // of a patch's descent, in each pass; at least 1
  int refinements = 2;   // rounds of variational refinement at each level; not negative
};

// A picture at the levels of a search, the finest first.
class SearchPyramid {
 public:
  static constexpr int kPatchSide = 8;  // OpenCV's presets'
  // Pixels around `padded`; OpenCV's, for its bytes: places are rounded with it. A patch's side
  // would do.
  static constexpr int kBorder = 16;

  struct Level {
    cv::Mat1b grey;
    cv::Mat1f padded;                  // grey, with more pixels around, which repeat its border
    cv::Mat1f gradient_x, gradient_y;  // Sobel's
    // Sums of products and of gradients over each patch: xx, xy, yy, x, y.
    cv::Mat_<cv::Vec<float, 5>> sums;
  };

  // picture: CV_8UC1, at least kPatchSide pixels in each direction. Where a level would be smaller,
  // the levels end before.
  SearchPyramid(const cv::Mat& picture, const InverseSearchOptions& options);

  const std::vector<Level>& levels() const { return levels_; }
  cv::Size picture_size() const { return picture_size_; }
  int finest_level() const { return finest_level_; }

 private:
  cv::Size picture_size_;
  int finest_level_;
  std::vector<Level> levels_;
};

// CV_32FC2, pixels of the picture, from `from` to `to`, which are of pictures of one size and of
// these options.
cv::Mat SearchFlow(const SearchPyramid& from, const SearchPyramid& to,
                   const InverseSearchOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FEATURES_INVERSE_SEARCH_H_
