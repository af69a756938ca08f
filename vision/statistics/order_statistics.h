// Order statistics of n values in linear time: medians, quantiles, a mode and a robust scale.
//
//   of rank r    the value before which r others lie in ascending order, r from 0
//   median       of rank floor(n / 2): of an even number, the upper of the two in the middle
//   quantile q   of rank floor(q (n - 1)); always one of the values
//
// There is at least one value, and none is NaN. What is "in place" changes the values' order.
//
//   scale        the standard deviation of a Gaussian from absolute differences from its centre,
//                sigma = max(floor, 1.4826 median |x - m|),  1 / 1.4826: the 0.75 quantile of N(0, 1);
//                outliers hardly count                                                       (MD1)
//
// Reference of (MD1): Rousseeuw & Croux, JASA 88 (1993), section 1.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace egosieve::vision {

// rank: below the number of values.
template <typename T>
T OfRankInPlace(std::vector<T>& values, size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

template <typename T>
T MedianInPlace(std::vector<T>& values) {
  return OfRankInPlace(values, values.size() / 2);
}

template <typename T>
T Median(std::vector<T> values) {
  return MedianInPlace(values);
}

// share: from 0 to 1.
template <typename T>
T QuantileInPlace(std::vector<T>& values, double share) {
  return OfRankInPlace(values, static_cast<size_t>(share * static_cast<double>(values.size() - 1)));
}

inline constexpr double kMadToDeviation = 1.4826;

// (MD1); the floor where there are no distances. distances: |x - m|, none NaN.
template <typename T>
double RobustScale(std::vector<T> distances, double floor) {
  return distances.empty() ? floor : std::max(floor, kMadToDeviation * MedianInPlace(distances));
}

struct ValueWindow {
  size_t first = 0, count = 0;
};

// The mode of values in ascending order: the first window that holds the most of them, with at most
// `width` between its first and last value.
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
