#include "vision/evidence/three_view.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "vision/evidence/epipolar_line.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr int64_t kFewestTriples = 20;
// The median of |e| / sigma in two dimensions is sqrt(2 log 2).
constexpr double kMedianOfRayleigh = 1.17741;
constexpr double kSignificant = 3.0;  // least flow of a point that the scale uses, in sigma
constexpr double kNearest = 0.05;     // least X_c(3) of a point that can be predicted
constexpr double kMostRatio = 1.6;    // of the lengths of the two steps

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Jacobian = Eigen::Matrix<double, 2, 6>;

// Step 1, the same for all iterations.
struct Base {
  bool valid = false;
  Eigen::Vector3d ray;       // K^-1 x_b
  Eigen::Vector2d line;      // d
  double depth = 0.0;        // r
  double depth_slope = 0.0;  // k
  double along = 0.0;        // s
};

Base BaseOf(const Pinhole& camera, const RelativePose& base_to_first, const PointTriple& triple) {
  Base base;
  const EpipolarLine line =
      LineOf(camera, base_to_first.rotation, base_to_first.translation, triple.b(0), triple.b(1));
  if (!line.valid) return base;
  base.along = line.Along(triple.a);
  if (!line.Reachable(base.along)) return base;
  base.ray = camera.Ray(triple.b(0), triple.b(1));
  base.line = line.direction;
  base.depth = line.InverseDepth(base.along);
  base.depth_slope = line.InverseDepthSlope(base.along);
  base.valid = std::isfinite(base.depth) && std::isfinite(base.depth_slope);
  return base;
}

struct Prediction {
  bool valid = false;
  Eigen::Vector2d residual, by_depth;  // e, u
  Eigen::Matrix2d covariance;          // (V2) over sigma^2
  Jacobian jacobian;                   // of the prediction, by (w, dtau)
};

Prediction Predict(const Pinhole& camera, const Eigen::Matrix3d& rotation,
                   const Eigen::Vector3d& tau, const Base& base, const Eigen::Vector2d& c) {
  Prediction prediction;
  const Eigen::Vector3d turned = rotation * base.ray;
  const Eigen::Vector3d point = turned + base.depth * tau;
  if (!(point(2) > kNearest)) return prediction;
  Eigen::Matrix<double, 2, 3> project;
  const double scale = camera.focal_pixels / point(2);
  project << scale, 0, -scale * point(0) / point(2), 0, scale, -scale * point(1) / point(2);
  Eigen::Matrix3d turn;
  turn << 0, turned(2), -turned(1), -turned(2), 0, turned(0), turned(1), -turned(0), 0;
  prediction.residual = c - camera.Project(point);
  prediction.by_depth = project * tau;
  prediction.jacobian << project * turn, base.depth * project;
  const Eigen::Vector2d ku = base.depth_slope * prediction.by_depth;
  const Eigen::Matrix2d by_b = Eigen::Matrix2d::Identity() - ku * base.line.transpose();
  prediction.covariance =
      Eigen::Matrix2d::Identity() + ku * ku.transpose() + by_b * by_b.transpose();
  prediction.valid = prediction.residual.allFinite() && prediction.covariance.allFinite();
  return prediction;
}

// |t_bc| / |t_ab| as the median ratio of the two inverse depths of points that have both.
double ScaleRatio(const std::vector<PointTriple>& triples, const std::vector<Base>& bases,
                  const RelativePose& second, const Pinhole& camera) {
  std::vector<double> ratios;
  const double least = kSignificant * second.noise_pixels;
  for (size_t i = 0; i < triples.size(); ++i) {
    if (!bases[i].valid || !(bases[i].along > least)) continue;
    const EpipolarLine line =
        LineOf(camera, second.rotation, second.translation, triples[i].b(0), triples[i].b(1));
    if (!line.valid) continue;
    const double s = line.Along(triples[i].c);
    if (!(s > least) || !line.Reachable(s)) continue;
    ratios.push_back(line.InverseDepth(s) / bases[i].depth);
  }
  return static_cast<int64_t>(ratios.size()) < kFewestTriples ? 0.0 : MedianInPlace(ratios);
}

// One Gauss-Newton step; false if it cannot be solved or is too large. Sets m, and P if `last`.
bool Step(const std::vector<PointTriple>& triples, const std::vector<Base>& bases,
          const Pinhole& camera, bool last, ThreeViewMotion& motion) {
  std::vector<Prediction> predictions;
  std::vector<double> distances;
  const double variance = motion.noise_pixels * motion.noise_pixels;
  for (size_t i = 0; i < triples.size(); ++i) {
    if (!bases[i].valid) continue;
    Prediction p = Predict(camera, motion.rotation, motion.translation, bases[i], triples[i].c);
    if (!p.valid) continue;
    p.covariance = (p.covariance * variance).inverse().eval();
    const double squared = p.residual.dot(p.covariance * p.residual);
    if (!std::isfinite(squared)) continue;
    predictions.push_back(p);
    distances.push_back(std::sqrt(std::max(0.0, squared)));
  }
  if (static_cast<int64_t>(distances.size()) < kFewestTriples) return false;
  std::vector<double> sorted = distances;
  motion.scale = std::max(0.3, MedianInPlace(sorted) / kMedianOfRayleigh);
  Matrix6d normal = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  for (size_t i = 0; i < predictions.size(); ++i) {
    const double ratio = distances[i] / (2.0 * motion.scale);
    const double weight = 1.0 / ((1.0 + ratio * ratio) * (1.0 + ratio * ratio));
    const Prediction& p = predictions[i];
    const Eigen::Matrix<double, 6, 2> weighted = weight * p.jacobian.transpose() * p.covariance;
    normal.noalias() += weighted * p.jacobian;
    gradient.noalias() += weighted * p.residual;
  }
  normal.diagonal().array() += 1e-12 * normal.trace() + 1e-300;
  const Eigen::LDLT<Matrix6d> factor(normal);
  if (last) {
    motion.covariance = motion.scale * motion.scale * factor.solve(Matrix6d::Identity());
    return motion.covariance.allFinite();
  }
  const Vector6d step = factor.solve(gradient);
  if (!(step.head<3>().norm() < 0.5) || !(step.tail<3>().norm() < motion.translation.norm())) {
    return false;
  }
  motion.rotation = RotationOf(step.head<3>()) * motion.rotation;
  motion.translation += step.tail<3>();
  return true;
}

}  // namespace

absl::Status ThreeViewOptions::Validate() const {
  return kernels::CheckOptions({
      {"max_triples", max_triples, max_triples >= kFewestTriples,
       absl::StrCat("be at least ", kFewestTriples)},
      {"iterations", iterations, iterations >= 1, "be positive"},
  });
}

ThreeViewMotion FitThreeViews(const std::vector<PointTriple>& triples, const RelativePose& first,
                              const RelativePose& second, const Pinhole& camera,
                              const ThreeViewOptions& options) {
  ThreeViewMotion motion;
  if (!first.found() || !second.found()) return motion;
  motion.base_to_first = Inverse(first);
  motion.noise_pixels = std::max(first.noise_pixels, second.noise_pixels);

  const int64_t count = triples.size();
  const int64_t chosen_count = std::min(count, options.max_triples);
  std::vector<PointTriple> chosen;
  std::vector<Base> bases;
  for (int64_t k = 0; k < chosen_count; ++k) {
    chosen.push_back(triples[k * count / chosen_count]);
    bases.push_back(BaseOf(camera, motion.base_to_first, chosen.back()));
  }
  const double ratio = ScaleRatio(chosen, bases, second, camera);
  if (!(ratio > 0.0) || !std::isfinite(ratio)) return motion;
  motion.rotation = second.rotation;
  motion.translation = ratio * second.translation;
  for (int k = 0; k < options.iterations; ++k) {
    if (!Step(chosen, bases, camera, /*last=*/false, motion)) return motion;
  }
  motion.speed_ratio = motion.translation.norm();
  const bool is_even = motion.speed_ratio < kMostRatio && motion.speed_ratio > 1.0 / kMostRatio;
  motion.found = is_even && Step(chosen, bases, camera, /*last=*/true, motion);
  return motion;
}

ThreeViewResidual MeasureThreeViews(const ThreeViewMotion& motion, const Pinhole& camera,
                                    const PointTriple& triple) {
  ThreeViewResidual result;
  if (!motion.found) return result;
  const Base base = BaseOf(camera, motion.base_to_first, triple);
  if (!base.valid) return result;
  const Prediction p = Predict(camera, motion.rotation, motion.translation, base, triple.c);
  if (!p.valid) return result;
  const double length = p.by_depth.norm();
  if (!(length > 1e-9)) return result;
  const Eigen::Vector2d along = p.by_depth / length;
  const double sigma = motion.scale * motion.noise_pixels;
  const Vector6d by_motion = p.jacobian.transpose() * along;
  result.direction = along;
  result.along_pixels = along.dot(p.residual);
  result.deviation_pixels = std::sqrt(sigma * sigma * along.dot(p.covariance * along) +
                                      by_motion.dot(motion.covariance * by_motion));
  result.present = std::isfinite(result.along_pixels) && result.deviation_pixels > 0.0 &&
                   std::isfinite(result.deviation_pixels);
  return result;
}

}  // namespace egosieve::vision
