#include "vision/features/spread.h"

#include <algorithm>
#include <numeric>

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

  const int columns = image_size.width / cell_pixels + 1;
  const int rows = image_size.height / cell_pixels + 1;
  std::vector<int32_t> taken(static_cast<size_t>(columns) * rows, 0);
  std::vector<int32_t> round(total);
  for (const int64_t i : order) {
    const int column = std::clamp(static_cast<int>(positions[i].x) / cell_pixels, 0, columns - 1);
    const int row = std::clamp(static_cast<int>(positions[i].y) / cell_pixels, 0, rows - 1);
    round[i] = taken[static_cast<size_t>(row) * columns + column]++;
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int64_t a, int64_t b) { return round[a] < round[b]; });
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace egosieve::vision
