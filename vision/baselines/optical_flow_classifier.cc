#include "vision/baselines/optical_flow_classifier.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/geometry/residual.h"
#include "vision/statistics/densest_window.h"

namespace egosieve::vision {
namespace {

constexpr double kFocalPerLongerSide = 0.7;

struct CameraMotion {
  Eigen::Matrix3d at_infinity = Eigen::Matrix3d::Identity();  // K R K^-1
  Eigen::Vector3d epipole = Eigen::Vector3d::Zero();          // K t
};

// Position of a pair relative to its epipolar line.
struct AlongLine {
  double across = 0.0;           // distance to the line, pixels
  double beyond_infinity = 0.0;  // from x2(0) in the direction of growing s, pixels
  double inverse_depth = 0.0;    // s of (OF1)
  bool valid = false;
};

AlongLine Locate(const CameraMotion& motion, const Eigen::Matrix3d& f, const PointPair& pair) {
  AlongLine result;
  const Eigen::Vector3d far = motion.at_infinity * Eigen::Vector3d(pair.x1, pair.y1, 1.0);
  const Eigen::Vector3d line = f * Eigen::Vector3d(pair.x1, pair.y1, 1.0);
  const double normal = line.head<2>().norm();
  if (!(far(2) > 0.0) || !(normal > 0.0)) return result;
  const Eigen::Vector2d start = far.head<2>() / far(2);
  // d x2 / d s at s = 0, up to a positive factor.
  const Eigen::Vector2d gradient = (motion.epipole.head<2>() - motion.epipole(2) * start) / far(2);
  Eigen::Vector2d direction(-line(1) / normal, line(0) / normal);
  if (direction.dot(gradient) < 0.0) direction = -direction;
  const double speed = direction.dot(gradient);
  if (!(speed > 0.0)) return result;
  const Eigen::Vector2d offset = Eigen::Vector2d(pair.x2, pair.y2) - start;
  result.across = std::abs(line.dot(Eigen::Vector3d(pair.x2, pair.y2, 1.0))) / normal;
  result.beyond_infinity = direction.dot(offset);
  // (OF1) along the line: q = s speed / (1 + s e_z / far_z), solved for s.
  const double bend = motion.epipole(2) / far(2);
  const double denominator = speed - result.beyond_infinity * bend;
  result.inverse_depth = denominator > 0.0 ? result.beyond_infinity / denominator
                                           : std::numeric_limits<double>::infinity();
  result.valid = true;
  return result;
}

// Place along the line of the inverse depth s.
double PlaceOf(const CameraMotion& motion, const PointPair& pair, double s) {
  const Eigen::Vector3d far = motion.at_infinity * Eigen::Vector3d(pair.x1, pair.y1, 1.0);
  const Eigen::Vector3d near = far + s * motion.epipole;
  if (!(near(2) > 0.0)) return std::numeric_limits<double>::infinity();
  return (near.head<2>() / near(2) - far.head<2>() / far(2)).norm();
}

double DepthViolation(const AlongLine& along) { return std::max(0.0, -along.beyond_infinity); }

// The four decompositions of E = K^T F K, and the one that the pairs violate least.
CameraMotion Decompose(const Eigen::Matrix3d& f, const Eigen::Matrix3d& k,
                       const std::vector<PointPair>& pairs) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(k.transpose() * f * k,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV();
  if (u.determinant() < 0.0) u = -u;
  if (v.determinant() < 0.0) v = -v;
  Eigen::Matrix3d w;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  constexpr size_t kEnough = 2000;
  constexpr double kMost = 10.0;  // pixels; limits the influence of movers
  const size_t step = std::max<size_t>(1, pairs.size() / kEnough);
  CameraMotion best;
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Matrix3d& turn : {w, Eigen::Matrix3d(w.transpose())}) {
    for (const double sign : {1.0, -1.0}) {
      CameraMotion motion;
      motion.at_infinity = k * u * turn * v.transpose() * k.inverse();
      motion.epipole = sign * (k * u.col(2));
      double sum = 0.0;
      for (size_t i = 0; i < pairs.size(); i += step) {
        const AlongLine along = Locate(motion, f, pairs[i]);
        // No point can lie beyond the epipole, which belongs to an infinite inverse depth.
        const bool possible = along.valid && std::isfinite(along.inverse_depth);
        sum += possible ? std::min(kMost, DepthViolation(along)) : kMost;
      }
      if (sum < least) {
        least = sum;
        best = motion;
      }
    }
  }
  return best;
}

// h: the densest value of the points in the lower half; 0 if no value is dense enough.
double RoadHeight(const CameraMotion& motion, const Eigen::Matrix3d& f, double focal,
                  double centre_y, const std::vector<PointPair>& pairs, double minimum_share) {
  constexpr double kWindow = 0.1;  // relative width in each direction
  constexpr size_t kFewest = 50;
  std::vector<double> logarithms;
  for (const PointPair& pair : pairs) {
    const double down = (pair.y1 - centre_y) / focal;
    if (!(down > 0.05)) continue;
    const AlongLine along = Locate(motion, f, pair);
    if (!along.valid || along.across > 1.0 || !(along.inverse_depth > 1e-6)) continue;
    const double height = down / along.inverse_depth;
    if (std::isfinite(height) && height > 0.0) logarithms.push_back(std::log(height));
  }
  if (logarithms.size() < kFewest) return 0.0;
  std::sort(logarithms.begin(), logarithms.end());
  const auto [first, count] = DensestWindow(logarithms, 2.0 * kWindow);
  const double median = logarithms[first + (count - 1) / 2];
  const double share = static_cast<double>(count) / static_cast<double>(logarithms.size());
  return share >= minimum_share ? std::exp(median) : 0.0;
}

}  // namespace

absl::Status OpticalFlowClassifierOptions::Validate() const {
  return kernels::CheckOptions({
      {"focal_length_pixels", focal_length_pixels, kernels::IsNotNegative(focal_length_pixels),
       "be positive, or 0 for a guess"},
      {"minimum_road_share", minimum_road_share, minimum_road_share > 0 && minimum_road_share <= 1,
       "be in (0, 1]"},
      {"tolerance_pixels", tolerance_pixels, kernels::IsNotNegative(tolerance_pixels),
       "not be negative"},
  });
}

absl::StatusOr<OpticalFlowClassification> ClassifyOpticalFlow(
    const std::vector<PointPair>& pairs, MotionModelKind kind, const Eigen::Matrix3d& matrix,
    int image_width, int image_height, const OpticalFlowClassifierOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (image_width < 1 || image_height < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("the image is ", image_width, "x", image_height, ": it has no pixels"));
  }
  OpticalFlowClassification result;
  result.violation_pixels = Residuals(kind, matrix, pairs, EpipolarDistance::kPointToLine);
  if (kind != MotionModelKind::kFundamental) return result;

  const double focal = options.focal_length_pixels > 0.0
                           ? options.focal_length_pixels
                           : kFocalPerLongerSide * std::max(image_width, image_height);
  const double centre_y = 0.5 * (image_height - 1);
  Eigen::Matrix3d k;
  k << focal, 0, 0.5 * (image_width - 1), 0, focal, centre_y, 0, 0, 1;
  const CameraMotion motion = Decompose(matrix, k, pairs);
  result.road_height =
      RoadHeight(motion, matrix, focal, centre_y, pairs, options.minimum_road_share);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const AlongLine along = Locate(motion, matrix, pairs[i]);
    if (!along.valid) continue;
    const double behind = DepthViolation(along) - options.tolerance_pixels;
    const double down = (pairs[i].y1 - centre_y) / focal;
    double below = 0.0;
    if (result.road_height > 0.0 && down > 0.0) {
      below = PlaceOf(motion, pairs[i], down / result.road_height) - along.beyond_infinity -
              options.tolerance_pixels;
    }
    const double violation = std::max(behind, below);
    if (!(violation > 0.0) || !std::isfinite(violation)) continue;
    result.violation_pixels[i] = std::hypot(along.across, violation);
  }
  return result;
}

}  // namespace egosieve::vision
