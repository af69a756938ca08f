#include "vision/matching/feature_matcher.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "vision/image/cell_grid.h"
#include "vision/matching/descriptor_search.h"

namespace egosieve::vision {
namespace {

constexpr int64_t kFeaturesPerTask = 512;

// A contiguous run of features of one kind.
struct Kind {
  int64_t begin = 0, end = 0;
  int64_t size() const { return end - begin; }
};

Kind KeyPoints(const FeatureSet& set) { return {0, set.key_point_count}; }
Kind Corners(const FeatureSet& set) { return {set.key_point_count, set.size()}; }

bool PassesRatio(const Nearest& nearest, double ratio) {
  if (nearest.second_distance == kNoDistance) return true;
  return nearest.distance < ratio * ratio * nearest.second_distance;
}

// rows: nearest of the first's `kind_first`, with indices relative to kind_second; columns
// likewise.
void AppendMutual(const NearestBothWays& nearest, Kind kind_first, Kind kind_second, double ratio,
                  std::vector<Match>& matches) {
  for (int64_t i = 0; i < kind_first.size(); ++i) {
    const Nearest& row = nearest.rows[i];
    if (row.index < 0 || nearest.columns[row.index] != i || !PassesRatio(row, ratio)) continue;
    Match match;
    match.first = static_cast<int32_t>(kind_first.begin + i);
    match.second = static_cast<int32_t>(kind_second.begin + row.index);
    if (row.second_distance != kNoDistance) {
      match.ratio = static_cast<float>(
          std::sqrt(static_cast<double>(row.distance) / static_cast<double>(row.second_distance)));
    }
    matches.push_back(match);
  }
}

// Features sorted into square cells, so that the candidates near a position are in few of them.
class CellIndex {
 public:
  CellIndex(const FeatureSet& set, Kind kind, float cell_pixels) {
    float right = 0.0F, bottom = 0.0F;
    for (int64_t i = kind.begin; i < kind.end; ++i) {
      right = std::max(right, set.positions[i].x);
      bottom = std::max(bottom, set.positions[i].y);
    }
    cells_ = CellsUpTo(right, bottom, cell_pixels);
    starts_.assign(cells_.size() + 1, 0);
    for (int64_t i = kind.begin; i < kind.end; ++i) ++starts_[CellOf(set.positions[i]) + 1];
    for (size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
    std::vector<int32_t> next(starts_.begin(), starts_.end() - 1);
    members_.resize(kind.size());
    for (int64_t i = kind.begin; i < kind.end; ++i) {
      members_[next[CellOf(set.positions[i])]++] = static_cast<int32_t>(i);
    }
  }

  // Calls visit(i) for every member of the cells that a square around `at` touches.
  template <typename Visit>
  void VisitNear(cv::Point2f at, float radius, const Visit& visit) const {
    const int left = cells_.ColumnOf(at.x - radius), right = cells_.ColumnOf(at.x + radius);
    const int top = cells_.RowOf(at.y - radius), bottom = cells_.RowOf(at.y + radius);
    for (int row = top; row <= bottom; ++row) {
      const int32_t end = starts_[cells_.Index(row, right) + 1];
      for (int32_t m = starts_[cells_.Index(row, left)]; m < end; ++m) {
        visit(members_[m]);
      }
    }
  }

 private:
  size_t CellOf(cv::Point2f p) const { return cells_.IndexOf(p.x, p.y); }

  SquareCells<float> cells_;
  std::vector<int32_t> starts_, members_;
};

void Consider(int32_t candidate, int32_t distance, Nearest& nearest) {
  const bool closer =
      distance < nearest.distance || (distance == nearest.distance && candidate < nearest.index);
  if (closer) {
    nearest.second_distance = nearest.distance;
    nearest.distance = distance;
    nearest.index = candidate;
  } else {
    nearest.second_distance = std::min(nearest.second_distance, distance);
  }
}

// Nearest in the window, in both directions: a pair is a candidate for both its ends or for none.
NearestBothWays SearchWindows(const FeatureSet& first, Kind kind_first, const FeatureSet& second,
                              Kind kind_second, const std::vector<cv::Point2f>& predicted,
                              const MatchOptions& options) {
  const float radius = static_cast<float>(options.window_radius_pixels);
  const CellIndex cells(second, kind_second, std::max(radius, 1.0F));
  NearestBothWays result;
  result.rows.resize(kind_first.size());
  result.columns.assign(kind_second.size(), -1);
  const int64_t tasks = (kind_first.size() + kFeaturesPerTask - 1) / kFeaturesPerTask;
  std::vector<std::vector<int32_t>> column_distance(
      tasks, std::vector<int32_t>(kind_second.size(), kNoDistance));
  std::vector<std::vector<int32_t>> column_index = column_distance;
  kernels::ParallelFor(tasks, {.threads = options.threads}, [&](int64_t task) {
    const int64_t begin = task * kFeaturesPerTask;
    const int64_t end = std::min(begin + kFeaturesPerTask, kind_first.size());
    for (int64_t i = begin; i < end; ++i) {
      const cv::Point2f at = predicted[kind_first.begin + i];
      if (!std::isfinite(at.x) || !std::isfinite(at.y)) continue;
      const uint8_t* descriptor = first.descriptor(kind_first.begin + i);
      cells.VisitNear(at, radius, [&](int32_t candidate) {
        const cv::Point2f offset = second.positions[candidate] - at;
        if (offset.x * offset.x + offset.y * offset.y > radius * radius) return;
        const int32_t distance = SquaredDistance(descriptor, second.descriptor(candidate));
        const int32_t j = candidate - static_cast<int32_t>(kind_second.begin);
        Consider(j, distance, result.rows[i]);
        if (distance < column_distance[task][j]) {
          column_distance[task][j] = distance;
          column_index[task][j] = static_cast<int32_t>(i);
        }
      });
    }
  });
  std::vector<int32_t> distance(kind_second.size(), kNoDistance);
  for (int64_t task = 0; task < tasks; ++task) {
    for (int64_t j = 0; j < kind_second.size(); ++j) {
      if (column_distance[task][j] < distance[j]) {
        distance[j] = column_distance[task][j];
        result.columns[j] = column_index[task][j];
      }
    }
  }
  return result;
}

}  // namespace

absl::Status MatchOptions::Validate() const {
  return kernels::CheckOptions({
      {"ratio", ratio, ratio > 0 && ratio <= 1, "be in (0, 1]"},
      {"window_radius_pixels", window_radius_pixels, kernels::IsPositive(window_radius_pixels),
       "be positive"},
      {"threads", threads, threads >= 1 && threads <= 256, "be from 1 to 256"},
  });
}

absl::StatusOr<std::vector<Match>> MatchFeatures(const FeatureSet& first, const FeatureSet& second,
                                                 const MatchOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  std::vector<Match> matches;
  for (const auto kind : {KeyPoints, Corners}) {
    const Kind a = kind(first), b = kind(second);
    const NearestBothWays nearest = SearchDescriptors(
        first.descriptor(a.begin), a.size(), second.descriptor(b.begin), b.size(), options.threads);
    AppendMutual(nearest, a, b, options.ratio, matches);
  }
  return matches;
}

absl::StatusOr<std::vector<Match>> MatchFeaturesNear(const FeatureSet& first,
                                                     const FeatureSet& second,
                                                     const std::vector<cv::Point2f>& predicted,
                                                     const MatchOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (predicted.size() != first.positions.size()) {
    return absl::InvalidArgumentError(absl::StrCat(predicted.size(), " predicted places for ",
                                                   first.positions.size(), " features"));
  }
  std::vector<Match> matches;
  for (const auto kind : {KeyPoints, Corners}) {
    const Kind a = kind(first), b = kind(second);
    AppendMutual(SearchWindows(first, a, second, b, predicted, options), a, b, options.ratio,
                 matches);
  }
  return matches;
}

}  // namespace egosieve::vision
