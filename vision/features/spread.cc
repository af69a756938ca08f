#include "vision/features/spread.h"

#include <algorithm>
#include <numeric>

#include "vision/image/cell_grid.h"

namespace egosieve::vision {

std::vector<int64_t> SpreadOverGrid(const std::vector<cv::Point2f>& positions,
                                    const std::vector<float>& responses, cv::Size image_size,
                                    int cell_pixels, int64_t count) {
  const int64_t total = static_cast<int64_t>(positions.size());
  std::vector<int64_t> order(total);
  std::iota(order.begin(), order.end(), int64_t{0});
  if (total <= count) return order;

  const auto stronger = [&](int64_t a, int64_t b) {
    return responses[a] != responses[b] ? responses[a] > responses[b] : a < b;
  };
  std::sort(order.begin(), order.end(), stronger);

  const auto cells = CellsUpTo(image_size.width, image_size.height, cell_pixels);
  std::vector<int32_t> taken(cells.size(), 0);
  std::vector<int32_t> round(total);
  for (const int64_t i : order) {
    round[i] = taken[cells.IndexOf(positions[i].x, positions[i].y)]++;
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int64_t a, int64_t b) { return round[a] < round[b]; });
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace egosieve::vision
