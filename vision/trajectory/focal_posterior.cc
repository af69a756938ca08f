#include "vision/trajectory/focal_posterior.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace egosieve::vision {
namespace {

constexpr double kLeastRatio = 0.25, kMostRatio = 4.0;
constexpr double kPriorRatio = 0.7, kPriorDeviation = 0.4;
constexpr double kPointsPerPair = 2.0;  // c
constexpr int kPairs = 300;             // of a pair of pictures that are used
constexpr int kIterations = 6;

double LogRatio(int k) {
  return std::log(kLeastRatio) +
         std::log(kMostRatio / kLeastRatio) * k / static_cast<double>(kFocalCandidates - 1);
}

// The motion that gives nearly the same flow through another lens.
TwoViewMotion Rescaled(const TwoViewMotion& motion, double ratio) {
  TwoViewMotion scaled = motion;
  const Eigen::AngleAxisd turn(motion.rotation);
  const Eigen::Vector3d w = turn.angle() * turn.axis();
  const Eigen::Vector3d changed(w(0) / ratio, w(1) / ratio, w(2));
  const double angle = changed.norm();
  scaled.rotation = angle > 1e-12 ? Eigen::AngleAxisd(angle, changed / angle).toRotationMatrix()
                                  : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const Eigen::Vector3d t(motion.translation(0), motion.translation(1),
                          motion.translation(2) * ratio);
  scaled.translation = t.normalized();
  scaled.mean_parallax = motion.mean_parallax * t.norm() / ratio;
  scaled.noise = motion.noise / ratio;
  scaled.moving_scale = motion.moving_scale / ratio;
  return scaled;
}

// Calls f(x_k, normalised weight).
template <typename Function>
void ForEachWeight(const std::array<double, kFocalCandidates>& log_weights, Function f) {
  const double top = *std::max_element(log_weights.begin(), log_weights.end());
  double sum = 0.0;
  for (const double w : log_weights) sum += std::exp(w - top);
  for (int k = 0; k < kFocalCandidates; ++k) {
    f(LogRatio(k), std::exp(log_weights[k] - top) / sum);
  }
}

}  // namespace

FocalPosterior::FocalPosterior() {
  for (int k = 0; k < kFocalCandidates; ++k) {
    const double z = (LogRatio(k) - std::log(kPriorRatio)) / kPriorDeviation;
    log_weights[k] = -0.5 * z * z;
  }
}

void FocalPosterior::Observe(const std::vector<PointPair>& pairs, const Pinhole& camera,
                             const TwoViewMotion& motion, cv::Size image) {
  if (!motion.found) return;
  TwoViewMotionOptions options;
  options.max_pairs = kPairs;
  options.iterations = kIterations;
  std::array<double, kFocalCandidates> likelihoods;
  for (int k = 0; k < kFocalCandidates; ++k) {
    const double focal = std::max(image.width, image.height) * std::exp(LogRatio(k));
    const Pinhole other = Pinhole::Of(image, focal);
    likelihoods[k] =
        RefineTwoViewMotion(pairs, other, Rescaled(motion, focal / camera.focal_pixels), options)
            .log_likelihood;
  }
  const double top = *std::max_element(likelihoods.begin(), likelihoods.end());
  if (!std::isfinite(top)) return;
  for (int k = 0; k < kFocalCandidates; ++k) {
    log_weights[k] += kPointsPerPair * std::max(likelihoods[k] - top, -5.0);
  }
}

double FocalPosterior::Estimate() const {
  double mean = 0.0;
  ForEachWeight(log_weights, [&](double x, double weight) { mean += weight * x; });
  return std::exp(mean);
}

double FocalPosterior::LogDeviation() const {
  double mean = 0.0, square = 0.0;
  ForEachWeight(log_weights, [&](double x, double weight) {
    mean += weight * x;
    square += weight * x * x;
  });
  return std::sqrt(std::max(square - mean * mean, 0.0));
}

}  // namespace egosieve::vision
