// The standard deviation of a Gaussian from absolute differences from its centre.
//
//   sigma = max(floor, 1.4826 median |x - m|),   1 / 1.4826: the 0.75 quantile of N(0, 1)    (MD1)
//
// Outliers hardly count. Reference: Rousseeuw & Croux, JASA 88 (1993), section 1. Cost: linear.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {

inline constexpr double kMadToDeviation = 1.4826;

// (MD1); the floor where there are no distances. distances: |x - m|, none NaN.
template <typename T>
double RobustScale(std::vector<T> distances, double floor) {
  return distances.empty() ? floor : std::max(floor, kMadToDeviation * MedianInPlace(distances));
}

}  // namespace egosieve::vision
