// Box means and grid interpolation in plain float64, by the formulas of
// kernels/ops/box_means.h and kernels/ops/grid_interpolation.h. Arguments must be valid: the
// public operations check them.
#pragma once

#include "kernels/base/image_grid.h"
#include "kernels/base/image_view.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::kernels::reference {

// points: N x 2, (x, y) in pixels; out: N x 6.
void BoxMeansAt(const ImageView& image, ConstMatrixView<double> points, int window_pixels,
                MatrixView<float> out);

void BoxMeansOnGrid(const ImageView& image, const ImageGrid& grid, int window_pixels,
                    MatrixView<float> out);

void GridInterpolation(const ImageGrid& grid, ConstMatrixView<float> values, MatrixView<float> out);

}  // namespace egosieve::kernels::reference
