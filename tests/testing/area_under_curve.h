// How well scores tell one class from the other.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace egosieve {

// Area under the ROC curve: P(score of a positive > score of another) + 1/2 P(equal) (Mann & Whitney,
// 1947). No score is NaN; NaN without one of the classes.
inline double AreaUnderCurve(const std::vector<double>& scores,
                             const std::vector<bool>& is_positive) {
  std::vector<size_t> order(scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scores[a] < scores[b]; });
  double positives = 0.0, others = 0.0, wins = 0.0;
  for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    double tied_positives = 0.0, tied_others = 0.0;
    for (; end < order.size() && scores[order[end]] == scores[order[begin]]; ++end) {
      (is_positive[order[end]] ? tied_positives : tied_others) += 1.0;
    }
    wins += tied_positives * (others + 0.5 * tied_others);
    positives += tied_positives;
    others += tied_others;
  }
  return wins / (positives * others);
}

}  // namespace egosieve
