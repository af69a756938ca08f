#include "vision/geometry/motion_model.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/geometry/ransac.h"
#include "vision/geometry/residual.h"
#include "vision/image/cell_grid.h"
#include "vision/statistics/order_statistics.h"
#include "vision/statistics/robust_scale.h"

namespace egosieve::vision {
namespace {

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
double NoiseForGric(const std::vector<Candidate>& candidates, double least) {
  for (const Candidate& candidate : candidates) {
    if (candidate.kind != MotionModelKind::kFundamental) continue;
    return RobustScale(candidate.residuals, least);
  }
  return least;
}

// (GR2).
bool StandsStill(const Candidate& candidate, const std::vector<double>& weights,
                 const MotionModelOptions& options) {
  if (candidate.kind != MotionModelKind::kStatic) return false;
  double still = 0.0;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (candidate.residuals[i] < options.still_pixels) still += weights[i];
  }
  return still >= options.still_share * static_cast<double>(weights.size());
}

void Judge(const Candidate& chosen, const MotionModelOptions& options, MotionModel& model) {
  model.kind = chosen.kind;
  model.matrix = chosen.matrix;
  model.inlier_count =
      std::count_if(chosen.residuals.begin(), chosen.residuals.end(),
                    [&](double residual) { return residual < options.support_pixels; });
  const double support =
      static_cast<double>(model.inlier_count) / static_cast<double>(model.pair_count);
  model.trusted = support >= options.minimum_support;
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
            const MotionModelOptions& options, MotionModel& model) {
  const std::vector<double> weights = EvenWeights(pairs);
  const double sigma = NoiseForGric(candidates, options.gric_sigma_pixels);
  const Candidate* best = nullptr;
  double least = 0.0;
  bool stands_still = false;
  for (const Candidate& candidate : candidates) {
    const double gric = MeanGric(candidate, weights, sigma);
    if (candidate.kind == MotionModelKind::kHomography) {
      model.parallax_pixels = Median(candidate.residuals);
    }
    stands_still = stands_still || StandsStill(candidate, weights, options);
    if (best == nullptr || (gric < least && !stands_still)) {
      best = &candidate;
      least = gric;
    }
  }
  model.reason.clear();
  Judge(*best, options, model);
  KeepRejected(*best, candidates, model);
}

}  // namespace

absl::Status MotionModelOptions::Validate() const {
  return kernels::CheckOptions({
      {"fundamental_threshold_pixels", fundamental_threshold_pixels,
       kernels::IsPositive(fundamental_threshold_pixels), "be positive"},
      {"homography_threshold_pixels", homography_threshold_pixels,
       kernels::IsPositive(homography_threshold_pixels), "be positive"},
      {"gric_sigma_pixels", gric_sigma_pixels, kernels::IsPositive(gric_sigma_pixels),
       "be positive"},
      {"still_pixels", still_pixels, kernels::IsPositive(still_pixels), "be positive"},
      {"support_pixels", support_pixels, kernels::IsPositive(support_pixels), "be positive"},
      {"still_share", still_share, still_share >= 0 && still_share <= 1, "be from 0 to 1"},
      {"minimum_support", minimum_support, minimum_support >= 0 && minimum_support <= 1,
       "be from 0 to 1"},
  });
}

absl::StatusOr<MotionModel> EstimateMotionModel(const std::vector<PointPair>& pairs,
                                                const MotionModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  MotionModel model;
  model.pair_count = static_cast<int64_t>(pairs.size());
  std::vector<Candidate> candidates;
  const bool is_auto = options.choice == MotionModelChoice::kAuto ||
                       options.choice == MotionModelChoice::kCalibrated;
  if (is_auto && !pairs.empty()) {
    candidates.push_back(
        MakeCandidate(MotionModelKind::kStatic, Eigen::Matrix3d::Identity(), pairs));
  }
  RansacOptions ransac;
  ransac.seed = options.seed;
  if (options.choice != MotionModelChoice::kFundamental) {
    ransac.threshold_pixels = options.homography_threshold_pixels;
    const absl::StatusOr<RansacResult> homography = EstimateHomography(pairs, ransac);
    if (homography.ok()) {
      candidates.push_back(MakeCandidate(MotionModelKind::kHomography, homography->matrix, pairs));
    } else {
      model.reason = std::string(homography.status().message());
    }
  }
  if (options.choice != MotionModelChoice::kHomography) {
    ransac.threshold_pixels = options.fundamental_threshold_pixels;
    const absl::StatusOr<RansacResult> fundamental = EstimateFundamental(pairs, ransac);
    if (fundamental.ok()) {
      candidates.push_back(
          MakeCandidate(MotionModelKind::kFundamental, fundamental->matrix, pairs));
    } else {
      model.reason = std::string(fundamental.status().message());
    }
  }
  if (candidates.empty()) return model;
  Choose(candidates, pairs, options, model);
  return model;
}

}  // namespace egosieve::vision
