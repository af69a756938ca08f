#include "vision/paper/feature_matcher.h"

#include "vision/paper/descriptor_search.h"

namespace egosieve::vision {
namespace {

constexpr double kRatio = 0.8;

// A contiguous run of features of one kind.
struct Kind {
  int64_t begin = 0, end = 0;
  int64_t size() const { return end - begin; }
};

Kind KeyPoints(const FeatureSet& set) { return {0, set.key_point_count}; }
Kind Corners(const FeatureSet& set) { return {set.key_point_count, set.size()}; }

bool PassesRatio(const Nearest& nearest) {
  if (nearest.second_distance == kNoDistance) return true;
  return nearest.distance < kRatio * kRatio * nearest.second_distance;
}

// rows: nearest of the first's `kind_first`, with indices relative to kind_second; columns
// likewise.
void AppendMutual(const NearestBothWays& nearest, Kind kind_first, Kind kind_second,
                  std::vector<Match>& matches) {
  for (int64_t i = 0; i < kind_first.size(); ++i) {
    const Nearest& row = nearest.rows[i];
    if (row.index < 0 || nearest.columns[row.index] != i || !PassesRatio(row)) continue;
    Match match;
    match.first = static_cast<int32_t>(kind_first.begin + i);
    match.second = static_cast<int32_t>(kind_second.begin + row.index);
    matches.push_back(match);
  }
}

}  // namespace

std::vector<Match> MatchFeatures(const FeatureSet& first, const FeatureSet& second, int threads) {
  std::vector<Match> matches;
  for (const auto kind : {KeyPoints, Corners}) {
    const Kind a = kind(first), b = kind(second);
    const NearestBothWays nearest = SearchDescriptors(
        first.descriptor(a.begin), a.size(), second.descriptor(b.begin), b.size(), threads);
    AppendMutual(nearest, a, b, matches);
  }
  return matches;
}

}  // namespace egosieve::vision
