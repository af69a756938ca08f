#include "vision/masks/motion_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "vision/masks/mover_motion.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

// Residuals beyond the scale weigh little. The scale is at least this many pixels, and at least
// this share of the median residual from a single motion, since flow errs more where it is large.
constexpr double kLeastScale = 1.0;
constexpr double kScaleShare = 0.25;
constexpr double kFitsOne = 0.05;   // mean cost below which one motion suffices
constexpr int kMinCells = 6;        // of each part
constexpr double kLeastHeld = 0.6;  // share of the cells that must hold over a horizon
constexpr double kLessCost = 0.6, kParting = 1.0;  // of (MS2)
constexpr int kSplitRounds = 8;
constexpr double kOnePiece = 0.7;
constexpr double kLeastHeldOfBoth = 0.4;
constexpr double kAllowedPixels = 1.5;
constexpr size_t kLeastToCompare = 3;

using Labels = std::vector<uint8_t>;

// The cells of a region that hold over one horizon.
struct Held {
  std::vector<int> index;  // into MovingCells
  std::vector<cv::Point> cells;
  std::vector<cv::Point2f> places, displacements;
};

Held HeldOf(const MovingCells& cells, const MovingCells::Horizon& horizon,
            const std::vector<int>& of) {
  Held held;
  for (const int i : of) {
    if (horizon.holds[i] == 0) continue;
    held.index.push_back(i);
    held.cells.push_back(cells.cells[i]);
    held.places.push_back(cells.places[i]);
    held.displacements.push_back(horizon.displacement[i]);
  }
  return held;
}

double Residual(const Held& held, size_t i, const MoverMotion& motion) {
  return cv::norm(cv::Point2d(held.displacements[i]) - motion.At(held.places[i]));
}

double Rho(double residual, double scale) {
  const double square = residual * residual;
  return square / (square + scale * scale);
}

struct Split {
  Labels labels;
  std::array<MoverMotion, 2> motions;
  std::array<std::vector<double>, 2> costs;  // of every cell by each motion
  double cost = 0.0;
};

MoverMotion FitPart(const Held& held, const Labels& labels, uint8_t label, double scale) {
  std::vector<cv::Point2f> places, displacements;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] != label) continue;
    places.push_back(held.places[i]);
    displacements.push_back(held.displacements[i]);
  }
  return FitMotion(places, displacements, scale);
}

Labels Assign(const Held& held, cv::Size grid, const Split& split) {
  cv::Mat1f lead = cv::Mat1f::zeros(grid);
  for (size_t i = 0; i < held.cells.size(); ++i) {
    lead(held.cells[i]) = static_cast<float>(split.costs[0][i] - split.costs[1][i]);
  }
  cv::boxFilter(lead, lead, -1, {3, 3}, {-1, -1}, false, cv::BORDER_CONSTANT);
  Labels labels;
  for (const cv::Point& cell : held.cells) labels.push_back(lead(cell) > 0.0f ? 1 : 0);
  return labels;
}

bool HaveEnough(const Labels& labels) {
  const auto second = std::count(labels.begin(), labels.end(), uint8_t{1});
  return second >= kMinCells && static_cast<int64_t>(labels.size()) - second >= kMinCells;
}

// (MS1) from `start`; the result has no labels where a part becomes too small.
Split SplitFrom(const Held& held, cv::Size grid, Labels start, double scale) {
  Split split;
  split.labels = std::move(start);
  for (int round = 0; round < kSplitRounds; ++round) {
    if (!HaveEnough(split.labels)) return {};
    for (const uint8_t part : {0, 1}) {
      split.motions[part] = FitPart(held, split.labels, part, scale);
      split.costs[part].clear();
      for (size_t i = 0; i < held.cells.size(); ++i) {
        split.costs[part].push_back(Rho(Residual(held, i, split.motions[part]), scale));
      }
    }
    Labels labels = Assign(held, grid, split);
    if (labels == split.labels) break;
    split.labels = std::move(labels);
  }
  if (!HaveEnough(split.labels)) return {};
  for (size_t i = 0; i < held.cells.size(); ++i) split.cost += split.costs[split.labels[i]][i];
  return split;
}

std::vector<Labels> Starts(const Held& held, const MoverMotion& one, double scale) {
  Labels misfits;
  for (size_t i = 0; i < held.cells.size(); ++i) {
    misfits.push_back(Residual(held, i, one) > 2.0 * scale ? 1 : 0);
  }
  std::vector<Labels> starts = {misfits};
  for (const auto* points : {&held.places, &held.displacements}) {
    for (const bool along_x : {true, false}) {
      std::vector<double> values;
      for (const cv::Point2f& p : *points) values.push_back(along_x ? p.x : p.y);
      const double middle = Median(values);
      Labels halves;
      for (const double value : values) halves.push_back(value >= middle ? 1 : 0);
      starts.push_back(std::move(halves));
    }
  }
  return starts;
}

// Whether the cells with that label are mostly connected.
bool IsOnePiece(const Held& held, const Labels& labels, uint8_t label, cv::Size grid) {
  cv::Mat1b part = cv::Mat1b::zeros(grid);
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == label) part(held.cells[i]) = 255;
  }
  cv::Mat pieces, stats, centres;
  const int count = cv::connectedComponentsWithStats(part, pieces, stats, centres, 8);
  int largest = 0;
  for (int i = 1; i < count; ++i) largest = std::max(largest, stats.at<int>(i, cv::CC_STAT_AREA));
  return largest >= kOnePiece * cv::countNonZero(part);
}

uint8_t SmallerPart(const Labels& labels) {
  const auto second = std::count(labels.begin(), labels.end(), uint8_t{1});
  return 2 * second <= static_cast<int64_t>(labels.size()) ? 1 : 0;
}

// (MS2)
bool IsAccepted(const Held& held, const Split& split, const MovingCells& cells) {
  const uint8_t smaller = SmallerPart(split.labels);
  double own = 0.0, others = 0.0, parting = 0.0;
  int count = 0;
  for (size_t i = 0; i < split.labels.size(); ++i) {
    if (split.labels[i] != smaller) continue;
    own += split.costs[smaller][i];
    others += split.costs[1 - smaller][i];
    parting += cv::norm(split.motions[0].At(held.places[i]) - split.motions[1].At(held.places[i]));
    ++count;
  }
  const double size = std::sqrt(static_cast<double>(count)) * cells.side;
  return own < kLessCost * others && parting >= kParting * size * count &&
         IsOnePiece(held, split.labels, smaller, cells.grid);
}

// Of (MS1) from all starts, the split of the smallest cost that (MS2) accepts.
std::optional<Split> BestSplit(const Held& held, const MovingCells& cells) {
  const MoverMotion one = FitMotion(held.places, held.displacements, kLeastScale);
  std::vector<double> residuals;
  for (size_t i = 0; i < held.cells.size(); ++i) residuals.push_back(Residual(held, i, one));
  const double scale = std::max(kLeastScale, kScaleShare * Median(residuals));
  double cost_of_one = 0.0;
  for (const double residual : residuals) cost_of_one += Rho(residual, scale);
  if (cost_of_one < kFitsOne * static_cast<double>(residuals.size())) return std::nullopt;
  std::optional<Split> best;
  for (Labels& start : Starts(held, one, scale)) {
    Split split = SplitFrom(held, cells.grid, std::move(start), scale);
    if (split.labels.empty() || (best && split.cost >= best->cost)) continue;
    if (IsAccepted(held, split, cells)) best = std::move(split);
  }
  return best;
}

// Cells that hold only over shorter horizons, because another object occludes them later, join the
// part with the more similar motion. It is compared over the longest horizon over which they hold.
void AddHiddenCells(const MovingCells& cells, const std::vector<int>& of, MotionSplit& parts) {
  std::vector<uint8_t> is_known(cells.places.size(), 0);
  for (const auto* part : {&parts.larger, &parts.smaller}) {
    for (const int i : *part) is_known[i] = 1;
  }
  for (const MovingCells::Horizon& horizon : cells.horizons) {
    const Held larger = HeldOf(cells, horizon, parts.larger);
    const Held smaller = HeldOf(cells, horizon, parts.smaller);
    const MoverMotion of_larger = FitMotion(larger.places, larger.displacements, kLeastScale);
    const MoverMotion of_smaller = FitMotion(smaller.places, smaller.displacements, kLeastScale);
    if (larger.cells.empty() || smaller.cells.empty()) continue;
    const Held all = HeldOf(cells, horizon, of);
    for (size_t i = 0; i < all.index.size(); ++i) {
      if (is_known[all.index[i]] != 0) continue;
      is_known[all.index[i]] = 1;
      const bool is_smaller = Residual(all, i, of_smaller) < Residual(all, i, of_larger);
      (is_smaller ? parts.smaller : parts.larger).push_back(all.index[i]);
    }
  }
}

}  // namespace

std::optional<MotionSplit> SplitByMotion(const MovingCells& cells, const std::vector<int>& of) {
  if (static_cast<int>(of.size()) < 2 * kMinCells) return std::nullopt;
  for (const MovingCells::Horizon& horizon : cells.horizons) {
    const Held held = HeldOf(cells, horizon, of);
    if (static_cast<double>(held.cells.size()) < kLeastHeld * static_cast<double>(of.size())) {
      continue;
    }
    const std::optional<Split> split = BestSplit(held, cells);
    if (!split) return std::nullopt;
    const uint8_t smaller = SmallerPart(split->labels);
    MotionSplit parts;
    for (size_t i = 0; i < split->labels.size(); ++i) {
      (split->labels[i] == smaller ? parts.smaller : parts.larger).push_back(held.index[i]);
    }
    AddHiddenCells(cells, of, parts);
    return parts;
  }
  return std::nullopt;
}

std::optional<double> MotionDistance(const MovingCells& cells, const std::vector<int>& part,
                                     const std::vector<int>& whole, double share) {
  for (const MovingCells::Horizon& horizon : cells.horizons) {
    const Held a = HeldOf(cells, horizon, part), b = HeldOf(cells, horizon, whole);
    const auto is_enough = [](const Held& held, const std::vector<int>& of) {
      return held.cells.size() >= kLeastToCompare &&
             static_cast<double>(held.cells.size()) >=
                 kLeastHeldOfBoth * static_cast<double>(of.size());
    };
    if (!is_enough(a, part) || !is_enough(b, whole)) continue;
    const MoverMotion motion = FitMotion(b.places, b.displacements, kLeastScale);
    std::vector<double> residuals;
    for (size_t i = 0; i < a.cells.size(); ++i) residuals.push_back(Residual(a, i, motion));
    return Median(residuals) / (kAllowedPixels + share * cv::norm(motion.shift));
  }
  return std::nullopt;
}

}  // namespace egosieve::vision
