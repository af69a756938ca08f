// Spreads values at features over an image: every grid pixel gets the value of its nearest feature.
#pragma once

#include <vector>

#include "kernels/base/matrix_view.h"
#include "vision/image/image_grid.h"

namespace egosieve::vision {

// positions: N x 2, (x, y) in pixels; values: N. Returns grid.size() values, row-major; all are
// `otherwise` if there are no features. Distances are Euclidean; of equally near features the first
// one counts. O(grid log N).
std::vector<float> SpreadToGrid(kernels::ConstMatrixView<double> positions,
                                const std::vector<double>& values, const ImageGrid& grid,
                                double otherwise = 0.0);

}  // namespace egosieve::vision
