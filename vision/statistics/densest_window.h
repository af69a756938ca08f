// The mode of sorted values: the first window of a given width that holds the most of them.
// Cost: linear.
#pragma once

#include <cstddef>
#include <vector>

namespace egosieve::vision {

struct ValueWindow {
  size_t first = 0, count = 0;
};

// The values in ascending order; a window's first and last value differ by at most `width`.
inline ValueWindow DensestWindow(const std::vector<double>& sorted, double width) {
  ValueWindow densest;
  size_t first = 0;
  for (size_t last = 0; last < sorted.size(); ++last) {
    while (sorted[last] - sorted[first] > width) ++first;
    if (last - first + 1 > densest.count) densest = {first, last - first + 1};
  }
  return densest;
}

}  // namespace egosieve::vision
