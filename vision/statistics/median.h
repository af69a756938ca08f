// The median in linear time; of an even number of values, the upper of the two in the middle.
#ifndef EGOSIEVE_VISION_STATISTICS_MEDIAN_H_
#define EGOSIEVE_VISION_STATISTICS_MEDIAN_H_

#include <algorithm>
#include <cstddef>
#include <vector>

namespace egosieve::vision {

// values: at least one, none NaN; their order changes.
template <typename T>
T MedianInPlace(std::vector<T>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <typename T>
T Median(std::vector<T> values) {
  return MedianInPlace(values);
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_STATISTICS_MEDIAN_H_
