// Order statistics of n values in linear time: medians and quantiles.
//
//   of rank r    the value before which r others lie in ascending order, r from 0
//   median       of rank floor(n / 2): of an even number, the upper of the two in the middle
//   quantile q   of rank floor(q (n - 1)); always one of the values
//
// There is at least one value, and none is NaN. What is "in place" changes the values' order.
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

}  // namespace egosieve::vision
