#include "vision/paper/motion_selection.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "vision/geometry/residual.h"
#include "vision/image/cell_grid.h"
#include "vision/paper/ransac.h"
#include "vision/statistics/order_statistics.h"
#include "vision/statistics/robust_scale.h"

namespace egosieve::vision {
namespace {

constexpr double kFundamentalThreshold = 0.25;  // RANSAC's T, pixels
constexpr double kHomographyThreshold = 1.0;
constexpr double kLeastSigma = 1.0;     // pixels
constexpr double kStillPixels = 0.25;   // (GR2)
constexpr double kStillShare = 0.4;     // (GR2)
constexpr double kSupportPixels = 2.0;  // trust
constexpr double kLeastSupport = 0.3;

struct Candidate {
  MotionModelKind kind = MotionModelKind::kNone;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  std::vector<double> residuals;
};

// w_i of (GR1): their mean is 1.
std::vector<double> EvenWeights(const std::vector<PointPair>& pairs) {
  constexpr CellGrid kCells{.columns = 12, .rows = 6};
  constexpr double kFewest = 5.0;  // a cell with fewer pairs than this weighs less than the others
  double right = 1.0, bottom = 1.0;
  for (const PointPair& pair : pairs) {
    right = std::max(right, pair.x2);
    bottom = std::max(bottom, pair.y2);
  }
  const auto cell_of = [&](const PointPair& pair) {
    const double x = pair.x2 / right * kCells.columns, y = pair.y2 / bottom * kCells.rows;
    return std::isnan(x) || std::isnan(y) ? 0 : kCells.IndexAt(x, y);
  };
  std::vector<double> counts(kCells.size(), 0.0);
  for (const PointPair& pair : pairs) counts[cell_of(pair)] += 1.0;
  std::vector<double> weights;
  double sum = 0.0;
  for (const PointPair& pair : pairs) {
    weights.push_back(1.0 / std::max(counts[cell_of(pair)], kFewest));
    sum += weights.back();
  }
  for (double& weight : weights) weight *= static_cast<double>(pairs.size()) / sum;
  return weights;
}

// (GR1) divided by n.
double MeanGric(const Candidate& candidate, const std::vector<double>& weights, double sigma) {
  const bool is_fundamental = candidate.kind == MotionModelKind::kFundamental;
  const int dimension = is_fundamental ? 3 : 2;
  const int parameters =
      is_fundamental ? 7 : (candidate.kind == MotionModelKind::kHomography ? 8 : 0);
  const double n = static_cast<double>(candidate.residuals.size());
  const double most = 4.0 - (dimension - 2) * std::log(4.0);
  const double scale = (is_fundamental ? 1.0 : 0.5) / (sigma * sigma);
  double sum = 0.0;
  for (size_t i = 0; i < weights.size(); ++i) {
    const double relative = candidate.residuals[i] * candidate.residuals[i] * scale;
    sum += weights[i] * (relative < most ? relative : most);
  }
  return sum / n + dimension * std::log(4.0) + parameters * std::log(4.0 * n) / n;
}

Candidate MakeCandidate(MotionModelKind kind, const Eigen::Matrix3d& matrix,
                        const std::vector<PointPair>& pairs) {
  return {kind, matrix, Residuals(kind, matrix, pairs, EpipolarDistance::kSampson)};
}

// sigma of (GR1).
double NoiseForGric(const std::vector<Candidate>& candidates) {
  for (const Candidate& candidate : candidates) {
    if (candidate.kind != MotionModelKind::kFundamental) continue;
    return RobustScale(candidate.residuals, kLeastSigma);
  }
  return kLeastSigma;
}

// (GR2).
bool StandsStill(const Candidate& candidate, const std::vector<double>& weights) {
  if (candidate.kind != MotionModelKind::kStatic) return false;
  double still = 0.0;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (candidate.residuals[i] < kStillPixels) still += weights[i];
  }
  return still >= kStillShare * static_cast<double>(weights.size());
}

void Judge(const Candidate& chosen, MotionModel& model) {
  model.kind = chosen.kind;
  model.matrix = chosen.matrix;
  model.inlier_count = std::count_if(chosen.residuals.begin(), chosen.residuals.end(),
                                     [&](double residual) { return residual < kSupportPixels; });
  const double support =
      static_cast<double>(model.inlier_count) / static_cast<double>(model.pair_count);
  model.trusted = support >= kLeastSupport;
  if (!model.trusted) {
    model.reason = absl::StrFormat("only %.0f %% of the matches agree on one motion of the camera",
                                   100.0 * support);
  }
}

// Keeps the competing model of the other kind. Static and homography count as one kind, since they
// are the same for a static camera.
void KeepRejected(const Candidate& chosen, const std::vector<Candidate>& candidates,
                  MotionModel& model) {
  const auto is_fundamental = [](const Candidate& candidate) {
    return candidate.kind == MotionModelKind::kFundamental;
  };
  for (const Candidate& candidate : candidates) {
    if (is_fundamental(candidate) == is_fundamental(chosen)) continue;
    model.rejected_kind = candidate.kind;
    model.rejected_matrix = candidate.matrix;
  }
}

void Choose(const std::vector<Candidate>& candidates, const std::vector<PointPair>& pairs,
            MotionModel& model) {
  const std::vector<double> weights = EvenWeights(pairs);
  const double sigma = NoiseForGric(candidates);
  const Candidate* best = nullptr;
  double least = 0.0;
  bool stands_still = false;
  for (const Candidate& candidate : candidates) {
    const double gric = MeanGric(candidate, weights, sigma);
    if (candidate.kind == MotionModelKind::kHomography) {
      model.parallax_pixels = Median(candidate.residuals);
    }
    stands_still = stands_still || StandsStill(candidate, weights);
    if (best == nullptr || (gric < least && !stands_still)) {
      best = &candidate;
      least = gric;
    }
  }
  model.reason.clear();
  Judge(*best, model);
  KeepRejected(*best, candidates, model);
}

absl::StatusOr<MotionModel> Estimate(const std::vector<PointPair>& pairs, bool fundamental_alone,
                                     uint64_t seed) {
  MotionModel model;
  model.pair_count = static_cast<int64_t>(pairs.size());
  std::vector<Candidate> candidates;
  if (!fundamental_alone && !pairs.empty()) {
    candidates.push_back(
        MakeCandidate(MotionModelKind::kStatic, Eigen::Matrix3d::Identity(), pairs));
  }
  const auto add = [&](MotionModelKind kind, double threshold, const auto& estimate) {
    const absl::StatusOr<Eigen::Matrix3d> fitted = estimate(pairs, threshold, seed);
    if (fitted.ok()) {
      candidates.push_back(MakeCandidate(kind, *fitted, pairs));
    } else {
      model.reason = std::string(fitted.status().message());
    }
  };
  if (!fundamental_alone) {
    add(MotionModelKind::kHomography, kHomographyThreshold, EstimateHomography);
  }
  add(MotionModelKind::kFundamental, kFundamentalThreshold, EstimateFundamental);
  if (!candidates.empty()) Choose(candidates, pairs, model);
  return model;
}

}  // namespace

absl::StatusOr<MotionModel> SelectMotion(const std::vector<PointPair>& pairs, uint64_t seed) {
  return Estimate(pairs, /*fundamental_alone=*/false, seed);
}

absl::StatusOr<MotionModel> FitFundamental(const std::vector<PointPair>& pairs, uint64_t seed) {
  return Estimate(pairs, /*fundamental_alone=*/true, seed);
}

}  // namespace egosieve::vision
