// Patches of 8 x 8 pixels, compared and aligned between pixels.
//
//   d_i = J(x_i + u) - I(x_i),  i over the pixels of a patch of I
//   E(u) = sum (d_i - mean d)^2                                                            (PC1)
//   c(u) = correlation of I(x_i) and J(x_i + u)                                             (PC2)
//   u <- u - H^-1 sum (g_i - mean g) d_i,  H = sum (g_i - mean g)(g_i - mean g)^T           (PC3)
//
// g is the gradient of I per pixel (Sobel). Brightness is no displacement: the means do not count.
// g belongs to I, so H is computed once, and (PC3) is a full Gauss-Newton step of E (inverse
// compositional alignment: Baker & Matthews, Lucas-Kanade 20 years on, IJCV 2004). A step is taken
// where it lowers E.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <opencv2/core.hpp>

namespace egosieve::vision {

inline constexpr int kFlowPatchSide = 8;

// A patch's row.
using FlowPatchRow = float __attribute__((vector_size(kFlowPatchSide * sizeof(float))));

// The corner of the patch around a pixel, which is its fourth in both directions.
inline cv::Point2f FlowPatchCorner(cv::Point2f centre) {
  return {centre.x - 3.0f, centre.y - 3.0f};
}

inline FlowPatchRow LoadFlowPatchRow(const float* from) {
  FlowPatchRow row;
  std::memcpy(&row, from, sizeof(row));
  return row;
}

// A picture whose outermost pixels go on outside.
class FlowPicture {
 public:
  explicit FlowPicture(const cv::Mat1b& grey);

  cv::Size size() const { return {padded_.cols - 2 * kBorder, padded_.rows - 2 * kBorder}; }
  // The position of pixel (x, y), at most kBorder pixels outside.
  const float* At(int x, int y) const { return padded_.ptr<float>(y + kBorder) + x + kBorder; }
  cv::Mat1f Pixels() const { return padded_(cv::Rect(cv::Point(kBorder, kBorder), size())); }
  size_t stride() const { return padded_.step1(); }
  bool HoldsPatch(cv::Point2f corner) const {
    return corner.x >= 0.0f && corner.y >= 0.0f &&
           corner.x <= static_cast<float>(size().width - kFlowPatchSide) &&
           corner.y <= static_cast<float>(size().height - kFlowPatchSide);
  }

  static constexpr int kBorder = kFlowPatchSide + 2;

 private:
  cv::Mat1f padded_;
};

// Rows of pixels interpolated bilinearly at one distance from whole positions.
class FlowPatchRows {
 public:
  // corner: of the patch. At least a row and a column of the patch stay in the picture; NaN is its
  // upper left corner.
  FlowPatchRows(const FlowPicture& picture, cv::Point2f corner);

  // Calls use(row, the row's pixels) for all rows from `first`, not before -1, until before `last`,
  // not after kFlowPatchSide + 1; `right` columns further, -1 to 1.
  template <typename Use>
  void ForEach(int first, int last, int right, const Use& use) const {
    const float* from = corner_ + first * stride_ + right;
    FlowPatchRow upper = Across(from);
    for (int row = first; row < last; ++row) {
      from += stride_;
      const FlowPatchRow lower = Across(from);
      use(row, above_ * upper + below_ * lower);
      upper = lower;
    }
  }
  template <typename Use>
  void ForEach(const Use& use) const {
    ForEach(0, kFlowPatchSide, 0, use);
  }

 private:
  FlowPatchRow Across(const float* from) const {
    return left_ * LoadFlowPatchRow(from) + right_ * LoadFlowPatchRow(from + 1);
  }

  std::ptrdiff_t stride_;
  const float* corner_;
  float left_, right_, above_, below_;
};

// What (PC1) to (PC3) need of J.
struct FlowPatchMatch {
  float error = 0.0f;    // E
  float product = 0.0f;  // of both patches about their means, summed
  cv::Point2f slope;     // sum (g - mean g) d
};

struct AlignedFlowPatch {
  cv::Point2f corner;
  FlowPatchMatch match;  // at `corner`
};

class FlowPatch {
 public:
  // At any position that FlowPatchRows takes.
  FlowPatch(const FlowPicture& picture, cv::Point2f corner);

  // Root of the sum of squares about the mean.
  float norm() const { return std::sqrt(squares_); }

  FlowPatchMatch Compare(const FlowPicture& other, cv::Point2f corner) const;
  // c; 0 where a patch is blank. match: what Compare returned.
  float Correlation(const FlowPatchMatch& match) const;
  float Correlation(const FlowPicture& other, cv::Point2f corner) const {
    return Correlation(Compare(other, corner));
  }

  // At most `most_steps` steps (PC3) from `start`, not further than a patch's side.
  AlignedFlowPatch Align(const FlowPicture& other, cv::Point2f start, int most_steps) const;
  // As above; at_start: what Compare returned there.
  AlignedFlowPatch Align(const FlowPicture& other, cv::Point2f start,
                         const FlowPatchMatch& at_start, int most_steps) const;

 private:
  std::array<FlowPatchRow, kFlowPatchSide> grey_, gradient_x_, gradient_y_;  // about their means
  float mean_ = 0.0f, squares_ = 0.0f;
  cv::Point2f slope_;                                                // sum (g - mean g) I
  float inverse_xx_ = 0.0f, inverse_xy_ = 0.0f, inverse_yy_ = 0.0f;  // of H
};

}  // namespace egosieve::vision
