// A map's value between the pixels of its grid.
#ifndef EGOSIEVE_TOOLS_EVALUATION_MAP_SAMPLE_H_
#define EGOSIEVE_TOOLS_EVALUATION_MAP_SAMPLE_H_

#include <opencv2/core.hpp>

#include "kernels/base/image_grid.h"

namespace egosieve::tools {

// The value at (x, y) in pixels of the image, linear between the four grid pixels around it.
double InterpolateAt(const cv::Mat1f& map, const kernels::ImageGrid& grid, double x, double y);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_MAP_SAMPLE_H_
