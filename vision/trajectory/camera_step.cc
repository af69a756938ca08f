#include "vision/trajectory/camera_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "vision/geometry/relative_pose.h"
#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

using Eigen::Vector3d;

constexpr int kFewestSharedPlaces = 20;
constexpr double kMeasurable = 3.0;     // least measurable parallax, in deviations
constexpr double kMostOnward = 1.5;     // bounds of (CS2): this and its inverse
constexpr double kUnknownOnward = 0.1;  // of the change of log length without (CS2)
constexpr double kFirstError = 1e3;     // of the log of the first length

// Exact inverse depth, in units of 1 / |t|, and its deviation. Deviation 0: the point moves.
struct Depth {
  double inverse = 0.0, deviation = 0.0;
};

Depth DepthOf(const TwoViewMotion& motion, const Pinhole& camera, const PointPair& pair) {
  const PairLikelihood likelihood = LikelihoodOf(motion, camera, pair);
  if (likelihood.log_static < likelihood.log_moving) return {};
  const Vector3d tau = motion.rotation.transpose() * motion.translation;
  const Vector3d ray = camera.Ray(pair.x1, pair.y1);
  const double length = (tau.head<2>() - tau(2) * ray.head<2>()).norm();
  const double parallax = likelihood.along / length, slope = 1.0 - tau(2) * parallax;
  return {InverseDepthOf(parallax, tau), motion.noise / (length * slope * slope)};
}

// (CS1); 0 where it is measurable at too few points.
double LengthRatio(const StepViews& views, const Pinhole& camera) {
  const TwoViewMotion behind = Inverse(*views.behind);
  double product = 0.0, square = 0.0;
  int count = 0;
  for (const PlaceOnBothSides& place : views.places) {
    const Depth a = DepthOf(*views.ahead, camera, place.ahead);
    if (!(a.deviation > 0.0 && a.inverse > kMeasurable * a.deviation)) continue;
    const PointPair back{place.behind.x2, place.behind.y2, place.behind.x1, place.behind.y1};
    const Depth b = DepthOf(behind, camera, back);
    if (!(b.deviation > 0.0)) continue;
    const double weight = 1.0 / (b.deviation * b.deviation);
    product += weight * b.inverse * a.inverse;
    square += weight * a.inverse * a.inverse;
    ++count;
  }
  return count >= kFewestSharedPlaces && product > 0.0 ? product / square : 0.0;
}

struct Gaussian {
  double mean = 0.0, variance = 0.0;
};

// The change of the log length from this step to the next (CS3).
Gaussian ChangeAfter(const CameraStep& step) {
  if (!(step.known && step.onward > 0.0)) return {0.0, kUnknownOnward * kUnknownOnward};
  return {std::log(step.onward), kOnwardError * kOnwardError};
}

// Logarithms of the steps' lengths.
std::vector<double> LogLengths(const std::vector<CameraStep>& steps) {
  std::vector<Gaussian> filtered(steps.size());
  const bool has_ground =
      std::any_of(steps.begin(), steps.end(), [](const auto& step) { return step.heights > 0.0; });
  Gaussian now{0.0, has_ground ? kFirstError * kFirstError : 0.0};
  for (size_t k = 0; k < steps.size(); ++k) {
    if (k > 0) {
      const Gaussian change = ChangeAfter(steps[k - 1]);
      now = {now.mean + change.mean, now.variance + change.variance};
    }
    if (steps[k].heights > 0.0) {
      const double gain = now.variance / (now.variance + kGroundError * kGroundError);
      now.mean += gain * (std::log(steps[k].heights) - now.mean);
      now.variance *= 1.0 - gain;
    }
    filtered[k] = now;
  }
  std::vector<double> lengths(steps.size());
  for (size_t k = steps.size(); k-- > 0;) {
    lengths[k] = filtered[k].mean;
    if (k + 1 == steps.size()) continue;
    const Gaussian change = ChangeAfter(steps[k]);
    const double gain = filtered[k].variance / (filtered[k].variance + change.variance);
    lengths[k] += gain * (lengths[k + 1] - filtered[k].mean - change.mean);
  }
  return lengths;
}

}  // namespace

CameraStep MeasureStep(const Eigen::Matrix3d& rotation, const StepViews& views,
                       const Pinhole& camera) {
  CameraStep step;
  step.known = true;
  const Eigen::AngleAxisd turn(rotation);
  step.rotation = turn.angle() * turn.axis();
  const bool behind = views.behind != nullptr && views.behind->HasParallax();
  const bool ahead = views.ahead != nullptr && views.ahead->HasParallax();
  if (behind) {
    step.direction = views.behind->translation;
  } else if (ahead) {
    step.direction = views.ahead->rotation.transpose() * views.ahead->translation;
  }
  const auto heights = [](const TwoViewMotion& motion, int pictures) {
    return motion.ground_heights / pictures;
  };
  if (behind) step.heights = heights(*views.behind, views.pictures_behind);
  if (!ahead) return step;
  const double ratio = views.behind == nullptr ? 0.0 : LengthRatio(views, camera);
  if (!(ratio > 0.0)) return step;
  const double faster = views.pictures_behind / (ratio * views.pictures_ahead);
  step.onward = std::clamp(std::pow(faster, 2.0 / (views.pictures_behind + views.pictures_ahead)),
                           1.0 / kMostOnward, kMostOnward);
  if (!(step.heights > 0.0)) {
    step.heights = heights(*views.ahead, views.pictures_ahead) / faster;
  }
  return step;
}

std::vector<Eigen::Isometry3d> ChainSteps(const std::vector<CameraStep>& steps) {
  const std::vector<double> lengths = LogLengths(steps);
  std::vector<Eigen::Isometry3d> poses(steps.size(), Eigen::Isometry3d::Identity());
  Eigen::Isometry3d last = Eigen::Isometry3d::Identity();  // X_k = last X_(k-1)
  for (size_t k = 1; k < steps.size(); ++k) {
    if (steps[k].known) {
      last.linear() = RotationOf(steps[k].rotation);
      last.translation() = std::exp(lengths[k]) * steps[k].direction;
    }
    poses[k] = poses[k - 1] * last.inverse();
  }
  return poses;
}

}  // namespace egosieve::vision
