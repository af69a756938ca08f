#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

std::vector<PointPair> PairsOf(const LabelledFrame& labels) {
  const bool on_first = labels.labelled.index == labels.first_index;
  const std::vector<double>& first = on_first ? labels.positions : labels.other_positions;
  const std::vector<double>& second = on_first ? labels.other_positions : labels.positions;
  std::vector<PointPair> pairs;
  for (int64_t i = 0; i < labels.size(); ++i) {
    pairs.push_back({first[2 * i], first[2 * i + 1], second[2 * i], second[2 * i + 1]});
  }
  return pairs;
}

}  // namespace egosieve::vision
