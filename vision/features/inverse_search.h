// Dense flow by inverse search (DIS), from coarse to fine. Every patch is searched for, starting
// from the displacements of the coarser level and of its neighbours; then the displacements of the
// patches are averaged.
//
//   d_i = J(x_i + u) - I(x_i)                                       8 x 8 pixels of a patch
//   E(u) = sum (d_i - mean d)^2                                                            (IS1)
//   u <- u - H^-1 sum (g_i - mean g) d_i,  g gradient of I,  H = sum g_i g_i^T             (IS2)
//   f(x) = sum_k w_k u_k / sum_k w_k,  w_k = 1 / max(1, |d_k(x)|)   patches k that hold x  (IS3)
//
// A patch starts from the flow of the coarser level. It takes over the displacement of a neighbour
// where its E is lower: of those above and left in a first pass, of those below and right in a
// second. Then it takes steps (IS2); the last is the one from where E no longer decreased. g is
// Sobel's sum, eight times the gradient per pixel, so a step is an eighth of a full one: full steps
// would follow the noise of the pictures. A descent that ends more than a patch's side from its
// start is undone. The rows of patches are searched in 8 stripes, and nothing is taken over between
// stripes. OpenCV then refines (IS3) variationally.
//
// Every sum is in the order of OpenCV's cv::DISOpticalFlow on x86-64, so that the flow has the same
// bytes. The data of one picture are computed once for both directions.
//
// Gradients belong to I, so H is computed once (inverse compositional alignment). Cost: linear in
// the pixels of the finest level. Reference: Kroeger, Timofte, Dai & Van Gool, Fast optical flow
// using dense inverse search (ECCV 2016).
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

struct InverseSearchOptions {
  int finest_level = 1;  // of the pyramid, where level k is reduced by 2^k; not negative
  int patch_stride = 3;  // pixels from patch to patch; 1 to 8
  int most_steps = 12;   // per patch and pass; at least 1
  int refinements = 2;   // rounds of variational refinement at each level; not negative
};

// A picture at the levels of the search, the finest first.
class SearchPyramid {
 public:
  static constexpr int kPatchSide = 8;  // as in OpenCV's presets
  // Pixels of padding in `padded`, as in OpenCV, since the rounding of positions depends on it. A
  // patch's side would suffice.
  static constexpr int kBorder = 16;

  struct Level {
    cv::Mat1b grey;
    cv::Mat1f padded;                  // grey, with kBorder pixels of repeated border
    cv::Mat1f gradient_x, gradient_y;  // Sobel's
    // Sums of products and of gradients over each patch: xx, xy, yy, x, y.
    cv::Mat_<cv::Vec<float, 5>> sums;
  };

  // picture: CV_8UC1, at least kPatchSide pixels in each direction. Levels that would be smaller
  // are left out.
  SearchPyramid(const cv::Mat& picture, const InverseSearchOptions& options);

  const std::vector<Level>& levels() const { return levels_; }
  cv::Size picture_size() const { return picture_size_; }
  int finest_level() const { return finest_level_; }

 private:
  cv::Size picture_size_;
  int finest_level_;
  std::vector<Level> levels_;
};

// Returns the flow from `from` to `to`: CV_32FC2, pixels of the picture. Both must be of pictures
// of one size and made with these options.
cv::Mat SearchFlow(const SearchPyramid& from, const SearchPyramid& to,
                   const InverseSearchOptions& options);

}  // namespace egosieve::vision
