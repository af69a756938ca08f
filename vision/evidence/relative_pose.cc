#include "vision/evidence/relative_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "vision/evidence/residual_scale.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr int64_t kFewestPairs = 20;
constexpr double kInlierMultiple = 3.0;    // of sigma, for (P3) and the parallax
constexpr double kSignificant = 3.0;       // least parallax of a point in (P3), in sigma
constexpr double kCertainRotation = 0.02;  // greatest deviation of the rotation, radians

using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Vector5d = Eigen::Matrix<double, 5, 1>;

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v(2), v(1), v(2), 0, -v(0), -v(1), v(0), 0;
  return m;
}

struct RayPair {
  Eigen::Vector3d first, second;
  PointPair pixels;
};

std::vector<RayPair> Choose(const std::vector<PointPair>& pairs, const Pinhole& camera,
                            int64_t max_pairs) {
  const int64_t count = pairs.size();
  const int64_t chosen = std::min(count, max_pairs);
  std::vector<RayPair> rays;
  rays.reserve(chosen);
  for (int64_t k = 0; k < chosen; ++k) {
    const PointPair& pair = pairs[k * count / chosen];
    rays.push_back({camera.Ray(pair.x1, pair.y1), camera.Ray(pair.x2, pair.y2), pair});
  }
  return rays;
}

// Sampson's distance in units of the focal length, signed, and its gradient by (w, dt).
struct Distance {
  double value = 0.0;
  Eigen::Vector3d by_rotation, by_translation;
};

Distance SignedSampson(const Eigen::Matrix3d& r, const Eigen::Vector3d& t, const RayPair& pair) {
  const Eigen::Vector3d moved = r * pair.first;
  const Eigen::Vector3d line2 = t.cross(moved);
  const Eigen::Vector3d normal = pair.second.cross(t);  // e = moved . normal
  const Eigen::Vector3d line1 = r.transpose() * normal;
  const double squares = line2.head<2>().squaredNorm() + line1.head<2>().squaredNorm();
  Distance distance{0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  if (!(squares > 1e-18)) return distance;
  const double scale = 1.0 / std::sqrt(squares);
  distance.value = moved.dot(normal) * scale;
  distance.by_rotation = moved.cross(normal) * scale;
  distance.by_translation = moved.cross(pair.second) * scale;
  return distance;
}

double Scale(const std::vector<RayPair>& rays, const Eigen::Matrix3d& r, const Eigen::Vector3d& t,
             double floor) {
  std::vector<double> distances;
  distances.reserve(rays.size());
  for (const RayPair& pair : rays) distances.push_back(SignedSampson(r, t, pair).value);
  return ResidualScale(std::move(distances), /*dimensions=*/1, floor);
}

// Two directions orthogonal to t and to each other.
Eigen::Matrix<double, 3, 2> Tangent(const Eigen::Vector3d& t) {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  int smallest = 0;
  t.cwiseAbs().minCoeff(&smallest);
  axis(smallest) = 1.0;
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = t.cross(axis).normalized();
  basis.col(1) = t.cross(basis.col(0));
  return basis;
}

// dd/dlog f, the distance in units of the unchanged focal length.
double ByFocal(const Eigen::Matrix3d& r, const Eigen::Vector3d& t, const RayPair& pair,
               double value) {
  constexpr double kStep = 1e-4;
  RayPair longer = pair;
  longer.first.head<2>() *= 1.0 - kStep;
  longer.second.head<2>() *= 1.0 - kStep;
  return (SignedSampson(r, t, longer).value * (1.0 + kStep) - value) / kStep;
}

// (P4), (P5), (P7). sigma in units of the focal length.
void Refine(const std::vector<RayPair>& rays, int iterations, double floor, RelativePose& pose,
            double& sigma) {
  sigma = Scale(rays, pose.rotation, pose.translation, floor);
  for (int k = 0; k <= iterations; ++k) {
    const Eigen::Matrix<double, 3, 2> tangent = Tangent(pose.translation);
    Matrix5d normal = Matrix5d::Zero();
    Vector5d gradient = Vector5d::Zero(), by_focal = Vector5d::Zero();
    for (const RayPair& pair : rays) {
      const Distance d = SignedSampson(pose.rotation, pose.translation, pair);
      const double ratio = d.value / (2.0 * sigma);
      const double weight = 1.0 / (1.0 + ratio * ratio);
      Vector5d jacobian;
      jacobian << d.by_rotation, tangent.transpose() * d.by_translation;
      const double w2 = weight * weight;  // squared, so that outliers have almost no weight
      normal.noalias() += w2 * jacobian * jacobian.transpose();
      gradient.noalias() += w2 * d.value * jacobian;
      if (k == iterations) {
        by_focal.noalias() +=
            w2 * ByFocal(pose.rotation, pose.translation, pair, d.value) * jacobian;
      }
    }
    normal.diagonal().array() += 1e-12 * normal.trace() + 1e-300;
    const Eigen::LDLT<Matrix5d> factor(normal);
    if (k == iterations) {
      const Matrix5d inverse = factor.solve(Matrix5d::Identity());
      pose.rotation_covariance = sigma * sigma * inverse.topLeftCorner<3, 3>();
      pose.rotation_by_focal = -(inverse * by_focal).head<3>();
      return;
    }
    const Vector5d step = -factor.solve(gradient);
    // A step of more than a radian: rotation and translation cannot be separated; keep the pose.
    if (!(step.norm() < 1.0)) {
      k = iterations - 1;
      continue;
    }
    pose.rotation = RotationOf(step.head<3>()) * pose.rotation;
    pose.translation = (pose.translation + tangent * step.tail<2>()).normalized();
    sigma = Scale(rays, pose.rotation, pose.translation, floor);
  }
}

struct Votes {
  int64_t in_front = 0, behind = 0;
  std::vector<double> parallax;      // |s| of the inliers, pixels
  std::vector<double> significance;  // of the inliers, |s| over the effects of noise and lens
};

Votes Count(const std::vector<RayPair>& rays, const Pinhole& camera, const RelativePose& pose,
            const RelativePoseOptions& options) {
  Votes votes;
  const double sigma = pose.noise_pixels;
  for (const RayPair& pair : rays) {
    const double distance =
        camera.focal_pixels * std::abs(SignedSampson(pose.rotation, pose.translation, pair).value);
    if (!(distance < kInlierMultiple * sigma)) continue;
    const EpipolarLine line =
        LineOf(camera, pose.rotation, pose.translation, pair.pixels.x1, pair.pixels.y1);
    if (!line.valid) continue;
    const double s = line.Along({pair.pixels.x2, pair.pixels.y2});
    const double lens = pose.focal_deviation * FlowByFocal(camera, pose, line);
    votes.parallax.push_back(std::abs(s));
    votes.significance.push_back(
        std::abs(s) / std::hypot(options.parallax_multiple * sigma, options.lens_multiple * lens));
    if (!(std::abs(s) > kSignificant * sigma)) continue;
    ++(s > 0 && line.Reachable(s) ? votes.in_front : votes.behind);
  }
  return votes;
}

// The value that the given share of the values exceeds.
double ExceededBy(std::vector<double> values, double share) {
  return QuantileInPlace(values, 1.0 - share);
}

// The pairs that may be static (P6).
std::vector<RayPair> WithoutNegativeDepths(const std::vector<RayPair>& rays, const Pinhole& camera,
                                           const RelativePose& pose) {
  std::vector<RayPair> possible;
  possible.reserve(rays.size());
  for (const RayPair& pair : rays) {
    const EpipolarLine line =
        LineOf(camera, pose.rotation, pose.translation, pair.pixels.x1, pair.pixels.y1);
    const double s = line.valid ? line.Along({pair.pixels.x2, pair.pixels.y2}) : 0.0;
    if (s > -kSignificant * pose.noise_pixels) possible.push_back(pair);
  }
  return possible;
}

}  // namespace

absl::Status RelativePoseOptions::Validate() const {
  return kernels::CheckOptions({
      {"max_pairs", max_pairs, max_pairs >= kFewestPairs,
       absl::StrCat("be at least ", kFewestPairs)},
      {"iterations", iterations, iterations >= 0, "not be negative"},
      {"noise_floor_pixels", noise_floor_pixels, kernels::IsPositive(noise_floor_pixels),
       "be positive"},
      {"parallax_share", parallax_share, parallax_share > 0 && parallax_share < 1,
       "be between 0 and 1"},
      {"parallax_multiple", parallax_multiple, kernels::IsPositive(parallax_multiple),
       "be positive"},
      {"lens_multiple", lens_multiple, kernels::IsNotNegative(lens_multiple), "not be negative"},
      {"focal_deviation", focal_deviation, kernels::IsNotNegative(focal_deviation),
       "not be negative"},
      {"cheirality_margin", cheirality_margin, cheirality_margin >= 0.5 && cheirality_margin <= 1,
       "lie in [0.5, 1]"},
  });
}

const char* Name(PoseOutcome outcome) {
  switch (outcome) {
    case PoseOutcome::kFound:
      return "found";
    case PoseOutcome::kUndetermined:
      return "undetermined";
    case PoseOutcome::kNoTranslation:
      return "no translation";
    case PoseOutcome::kAmbiguousDirection:
      return "ambiguous direction";
  }
  return "unknown";
}

Eigen::Matrix3d RotationOf(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (!(angle > 1e-12)) return Eigen::Matrix3d::Identity() + Cross(w);
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

RelativePose EstimateRelativePose(const std::vector<PointPair>& pairs,
                                  const Eigen::Matrix3d& fundamental, const Pinhole& camera,
                                  const RelativePoseOptions& options) {
  RelativePose pose;
  pose.focal_deviation = options.focal_deviation;
  if (static_cast<int64_t>(pairs.size()) < kFewestPairs || !fundamental.allFinite()) return pose;
  const std::vector<RayPair> rays = Choose(pairs, camera, options.max_pairs);
  const Eigen::Matrix3d k = camera.Matrix();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(k.transpose() * fundamental * k,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()(1) > 0)) return pose;
  Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV(), w;
  if (u.determinant() < 0) u.col(2) *= -1;
  if (v.determinant() < 0) v.col(2) *= -1;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d one = u * w * v.transpose();
  const Eigen::Matrix3d other = u * w.transpose() * v.transpose();
  // The twisted pair differs by half a turn about t. Between neighbouring frames the rotation is
  // the smaller one.
  pose.rotation = one.trace() > other.trace() ? one : other;
  pose.translation = u.col(2);
  if (!(pose.rotation.trace() > 1.0)) return pose;

  double sigma = 0.0;
  Refine(rays, options.iterations, options.noise_floor_pixels / camera.focal_pixels, pose, sigma);
  pose.noise_pixels = sigma * camera.focal_pixels;
  const double uncertainty = std::sqrt(pose.rotation_covariance.trace());
  if (!(uncertainty < kCertainRotation)) return pose;
  const Votes votes = Count(rays, camera, pose, options);
  if (static_cast<int64_t>(votes.parallax.size()) < kFewestPairs) return pose;
  pose.parallax_pixels = ExceededBy(votes.parallax, options.parallax_share);
  if (!(ExceededBy(votes.significance, options.parallax_share) > 1.0)) {
    pose.outcome = PoseOutcome::kNoTranslation;
    return pose;
  }
  RelativePose backwards = pose;
  backwards.translation = -pose.translation;
  const Votes opposite = Count(rays, camera, backwards, options);
  const bool turned = opposite.in_front > votes.in_front;
  if (turned) pose.translation = -pose.translation;
  const Votes& winner = turned ? opposite : votes;
  const double all = static_cast<double>(winner.in_front + winner.behind);
  if (!(winner.in_front >= options.cheirality_margin * all)) {
    pose.outcome = PoseOutcome::kAmbiguousDirection;
    return pose;
  }
  pose.outcome = PoseOutcome::kFound;
  const std::vector<RayPair> possible = WithoutNegativeDepths(rays, camera, pose);
  if (options.iterations == 0 || static_cast<int64_t>(possible.size()) < kFewestPairs) return pose;
  Refine(possible, options.iterations, options.noise_floor_pixels / camera.focal_pixels, pose,
         sigma);
  pose.noise_pixels = sigma * camera.focal_pixels;
  return pose;
}

double FlowByFocal(const Pinhole& camera, const RelativePose& pose, const EpipolarLine& line) {
  const Eigen::Vector3d& a = line.ray;
  const Eigen::Vector3d b = pose.rotation.col(2);
  const Eigen::Vector2d& d = line.direction;
  // d^T (dproject/dA).
  Eigen::Vector3d g;
  g << d, -d.dot(a.head<2>()) / a(2);
  g *= camera.focal_pixels / a(2);
  const Eigen::Vector2d from_centre(line.infinity(0) - camera.centre_x,
                                    line.infinity(1) - camera.centre_y);
  return -d.dot(from_centre) - g.dot(b) - a.cross(g).dot(pose.rotation_by_focal);
}

Eigen::Matrix3d FundamentalOfPose(const RelativePose& pose, const Pinhole& camera) {
  const Eigen::Matrix3d inverse = camera.Matrix().inverse();
  return (inverse.transpose() * Cross(pose.translation) * pose.rotation * inverse).normalized();
}

RelativePose Inverse(const RelativePose& pose) {
  RelativePose inverse = pose;
  inverse.rotation = pose.rotation.transpose();
  inverse.translation = -(inverse.rotation * pose.translation);
  return inverse;
}

}  // namespace egosieve::vision
