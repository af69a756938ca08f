#include "vision/geometry/motion_model.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "vision/geometry/ransac.h"
#include "vision/geometry/residual.h"

namespace egosieve::vision {
namespace {

struct Candidate {
  MotionModelKind kind = MotionModelKind::kNone;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  std::vector<double> residuals;
  double gric = 0.0;  // (G1) / n
};

// (G1) divided by n.
double MeanGric(const std::vector<double>& residuals, double sigma, int dimension, int parameters) {
  const double n = static_cast<double>(residuals.size());
  const double most = 2.0 * (4 - dimension);
  double sum = 0.0;
  for (const double e : residuals) {
    const double relative = e * e / (sigma * sigma);
    sum += relative < most ? relative : most;
  }
  return sum / n + dimension * std::log(4.0) + parameters * std::log(4.0 * n) / n;
}

Candidate MakeCandidate(MotionModelKind kind, const Eigen::Matrix3d& matrix,
                        const std::vector<PointPair>& pairs, double sigma) {
  Candidate candidate{kind, matrix, {}, 0.0};
  candidate.residuals = Residuals(kind, matrix, pairs, EpipolarDistance::kSampson);
  const int dimension = kind == MotionModelKind::kFundamental ? 3 : 2;
  const int parameters = kind == MotionModelKind::kFundamental  ? 7
                         : kind == MotionModelKind::kHomography ? 8
                                                                : 0;
  candidate.gric = MeanGric(candidate.residuals, sigma, dimension, parameters);
  return candidate;
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

}  // namespace

absl::Status MotionModelOptions::Validate() const {
  const auto positive = [](const char* name, double value) {
    if (value > 0 && std::isfinite(value)) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(name, " is ", value, "; it must be positive"));
  };
  EGOSIEVE_RETURN_IF_ERROR(positive("fundamental_threshold_pixels", fundamental_threshold_pixels));
  EGOSIEVE_RETURN_IF_ERROR(positive("homography_threshold_pixels", homography_threshold_pixels));
  EGOSIEVE_RETURN_IF_ERROR(positive("gric_sigma_pixels", gric_sigma_pixels));
  EGOSIEVE_RETURN_IF_ERROR(positive("support_pixels", support_pixels));
  if (!(minimum_support >= 0 && minimum_support <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("minimum_support is ", minimum_support, "; it must be from 0 to 1"));
  }
  return absl::OkStatus();
}

absl::StatusOr<MotionModel> EstimateMotionModel(const std::vector<PointPair>& pairs,
                                                const MotionModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  MotionModel model;
  model.pair_count = static_cast<int64_t>(pairs.size());
  std::optional<Candidate> best;
  const auto consider = [&](Candidate candidate, double& gric) {
    gric = candidate.gric;
    if (!best.has_value() || candidate.gric < best->gric) best = std::move(candidate);
  };
  const double sigma = options.gric_sigma_pixels;

  if (options.choice == MotionModelChoice::kAuto && !pairs.empty()) {
    consider(MakeCandidate(MotionModelKind::kStatic, Eigen::Matrix3d::Identity(), pairs, sigma),
             model.static_gric);
  }
  RansacOptions ransac;
  ransac.seed = options.seed;
  if (options.choice != MotionModelChoice::kFundamental) {
    ransac.threshold_pixels = options.homography_threshold_pixels;
    const absl::StatusOr<RansacResult> homography = EstimateHomography(pairs, ransac);
    if (homography.ok()) {
      consider(MakeCandidate(MotionModelKind::kHomography, homography->matrix, pairs, sigma),
               model.homography_gric);
    } else {
      model.reason = std::string(homography.status().message());
    }
  }
  if (options.choice != MotionModelChoice::kHomography) {
    ransac.threshold_pixels = options.fundamental_threshold_pixels;
    const absl::StatusOr<RansacResult> fundamental = EstimateFundamental(pairs, ransac);
    if (fundamental.ok()) {
      consider(MakeCandidate(MotionModelKind::kFundamental, fundamental->matrix, pairs, sigma),
               model.fundamental_gric);
    } else {
      model.reason = std::string(fundamental.status().message());
    }
  }
  if (!best.has_value()) return model;
  model.reason.clear();
  Judge(*best, options, model);
  return model;
}

}  // namespace egosieve::vision
