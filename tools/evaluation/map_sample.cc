#include "tools/evaluation/map_sample.h"

#include <algorithm>

namespace egosieve::tools {
namespace {

// The grid pixel at or before a position, and the position's distance from it in steps, in [0, 1].
struct Place {
  int before = 0;
  double share = 0.0;
};

Place PlaceOn(double position, int stride, int count, int last_pixel) {
  if (count < 2) return {};
  Place place;
  place.before = std::clamp(static_cast<int>(position / stride), 0, count - 2);
  const int low = place.before * stride, high = std::min(low + stride, last_pixel);
  place.share = std::clamp((position - low) / (high - low), 0.0, 1.0);
  return place;
}

}  // namespace

double InterpolateAt(const cv::Mat1f& map, const kernels::ImageGrid& grid, double x, double y) {
  const Place column = PlaceOn(x, grid.stride, grid.columns(), grid.width - 1);
  const Place row = PlaceOn(y, grid.stride, grid.rows(), grid.height - 1);
  const int right = std::min(column.before + 1, map.cols - 1);
  const int below = std::min(row.before + 1, map.rows - 1);
  const auto between = [](double low, double high, double share) {
    return low + share * (high - low);
  };
  return between(between(map(row.before, column.before), map(row.before, right), column.share),
                 between(map(below, column.before), map(below, right), column.share), row.share);
}

}  // namespace egosieve::tools
