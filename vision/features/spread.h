// Chooses a number of features evenly over an image.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

// Takes the strongest feature of each cell of a grid, then the second of each, and so on, until
// `count` are chosen. Within a round stronger ones come first; of equal responses, the earlier.
// Returns the chosen indices in increasing order. positions and responses must have the same
// length; cell_pixels > 0.
std::vector<int64_t> SpreadOverGrid(const std::vector<cv::Point2f>& positions,
                                    const std::vector<float>& responses, cv::Size image_size,
                                    int cell_pixels, int64_t count);

}  // namespace egosieve::vision
