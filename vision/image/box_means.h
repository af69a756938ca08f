// Places in an image and the means of the image's channels around them:
//
//   x = (u, v, 0.114 m_0 + 0.587 m_1 + 0.299 m_2, m_2, m_1, m_0)
//
// u, v as in vision/image/image_grid.h; m_c is the mean of channel c over a square window of
// `window_pixels` around the pixel, clipped at the image border (the mean is over existing pixels),
// mapped from [0, 255] to [-1, 1]. In an image of one channel all four means are equal. A point
// between pixels has the window of the nearest pixel and its own u, v. The weights are those of
// luma (ITU-R BT.601) for the channels B, G, R.
//
// After an error `out` is unchanged.
#pragma once

#include "absl/status/status.h"
#include "kernels/base/matrix_view.h"
#include "vision/image/image_grid.h"
#include "vision/image/image_view.h"

namespace egosieve::vision {

inline constexpr int kBoxMeanColumns = 6;

struct BoxMeanOptions {
  int window_pixels = 7;  // side of the square window; odd
  absl::Status Validate() const;
};

// out: grid.size() x 6, row-major over the grid's rows and columns.
absl::Status BoxMeansOnGrid(const ImageView& image, const ImageGrid& grid,
                            const BoxMeanOptions& options, kernels::MatrixView<float> out);

// points: N x 2, (x, y) in pixels, inside the image; out: N x 6. At a grid's pixels the results
// equal BoxMeansOnGrid's bit for bit.
absl::Status BoxMeansAt(const ImageView& image, kernels::ConstMatrixView<double> points,
                        const BoxMeanOptions& options, kernels::MatrixView<float> out);

}  // namespace egosieve::vision
