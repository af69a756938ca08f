// Places in an image and the means of the image's channels around them, the six inputs of the
// segmentation's Gaussian process (paper, section III):
//
//   x = (u, v, 0.114 m_0 + 0.587 m_1 + 0.299 m_2, m_2, m_1, m_0) = (u, v, I_M, I_R, I_G, I_B)
//
// u, v as in vision/image/image_grid.h; m_c is the mean of channel c over a square window of
// `window_pixels` around the pixel, clipped at the image border (the mean is over existing pixels),
// mapped from [0, 255] to [-1, 1]. In an image of one channel all four means are equal. A point
// between pixels has the window of the nearest pixel and its own u, v. The weights are those of
// luma (ITU-R BT.601) for the channels B, G, R.
//
// They are computed at given places, for learning, and on a grid over the whole image, for
// inference; at a grid's pixels both give the same bytes.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/matrix_view.h"
#include "vision/image/image_grid.h"
#include "vision/image/image_view.h"

namespace egosieve::vision {

inline constexpr int kBoxMeanColumns = 6;
// Sides of the window are odd; up to kMostWindowPixels sums of 8-bit values stay below 2^31.
inline constexpr int kWindowPixels = 7, kMostWindowPixels = 2001;

// picture: CV_8UC1 or CV_8UC3.
ImageView ViewOf(const cv::Mat& picture);

// Returns grid.size() x 6, row-major over the grid's rows and columns. grid: of the image's size.
std::vector<float> BoxMeansOnGrid(const ImageView& image, const ImageGrid& grid,
                                  int window_pixels = kWindowPixels);

// points: N x 2, (x, y) in pixels; InvalidArgument unless inside the image. Returns N x 6.
absl::StatusOr<std::vector<float>> BoxMeansAt(const ImageView& image,
                                              kernels::ConstMatrixView<double> points,
                                              int window_pixels = kWindowPixels);

}  // namespace egosieve::vision
