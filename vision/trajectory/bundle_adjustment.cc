#include "vision/trajectory/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "vision/evidence/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/statistics/median.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {
namespace {

constexpr double kLogFocalDeviation = 0.4, kRadialDeviation = 0.1, kScaleDeviation = 0.1;
constexpr double kCauchyScale = 2.0;
constexpr double kStartNoisePixels = 1.0, kLeastNoisePixels = 0.1;
constexpr size_t kFewestTracks = 20;
constexpr int kUndistortSteps = 4;
constexpr int kIterations = 50;
constexpr std::array<double, 3> kStartRatios = {0.5, 0.9, 1.8};  // f / L

// (BA3) / sigma of one observation. lens: log(f / L), kappa. pose: R as angle times axis, then t.
struct Reprojection {
  cv::Point2d start,
      seen;            // in the first picture and in this one, from the principal point, pixels
  double side = 0.0;   // L
  double noise = 0.0;  // sigma

  template <typename T>
  bool operator()(const T* lens, const T* pose, const T* inverse_depth, T* residual) const {
    const T focal = exp(lens[0]) * side;
    const T ux = start.x / focal, uy = start.y / focal;
    T ray[3] = {ux, uy, T(1.0)};
    // The fixed point of v = u / (1 + kappa |v|^2).
    for (int k = 0; k < kUndistortSteps; ++k) {
      const T factor = 1.0 + lens[1] * (ray[0] * ray[0] + ray[1] * ray[1]);
      ray[0] = ux / factor;
      ray[1] = uy / factor;
    }
    T point[3];
    ceres::AngleAxisRotatePoint(pose, ray, point);
    for (int k = 0; k < 3; ++k) point[k] += *inverse_depth * pose[3 + k];
    if (!(point[2] > 1e-3)) return false;
    const T x = point[0] / point[2], y = point[1] / point[2];
    const T scale = focal * (1.0 + lens[1] * (x * x + y * y));
    residual[0] = (scale * x - seen.x) / noise;
    residual[1] = (scale * y - seen.y) / noise;
    return true;
  }
};

struct ScaleGauge {
  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    const T square = pose[3] * pose[3] + pose[4] * pose[4] + pose[5] * pose[5];
    if (!(square > 1e-12)) return false;
    residual[0] = (sqrt(square) - 1.0) / kScaleDeviation;
    return true;
  }
};

struct LensPrior {
  template <typename T>
  bool operator()(const T* lens, T* residual) const {
    residual[0] = (lens[0] - std::log(AdjustedLens().focal_ratio)) / kLogFocalDeviation;
    residual[1] = lens[1] / kRadialDeviation;
    return true;
  }
};

// All unknowns in one array, so that their order in memory, by which Ceres orders them, is always
// the same: the lens, then window by window the poses of pictures 1..K and the inverse depths.
using State = std::vector<double>;

struct Observation {
  size_t window = 0;
  size_t pose = 0, inverse_depth = 0;  // in the State
  cv::Point2d start, seen;             // as in Reprojection
};

class Adjustment {
 public:
  Adjustment(std::vector<const TrackWindow*> windows, cv::Size image)
      : windows_(std::move(windows)), image_(image), side_(std::max(image.width, image.height)) {
    const cv::Point2d centre(0.5 * (image.width - 1), 0.5 * (image.height - 1));
    size_ = kLens;
    for (size_t w = 0; w < windows_.size(); ++w) {
      const TrackWindow& window = *windows_[w];
      first_pose_.push_back(size_);
      const size_t first_depth = size_ + kPose * (window.pictures - 1);
      size_ = first_depth + window.tracks.size();
      for (size_t i = 0; i < window.tracks.size(); ++i) {
        const auto& track = window.tracks[i];
        for (size_t k = 1; k < track.size(); ++k) {
          observations_.push_back({w, first_pose_[w] + kPose * (k - 1), first_depth + i,
                                   track[0] - centre, track[k] - centre});
        }
      }
    }
  }

  // Motions and depths by pairs of pictures.
  State Start(double focal_ratio) const {
    State state(size_, 0.0);
    state[0] = std::log(focal_ratio);
    const Pinhole camera = Pinhole::Of(image_, focal_ratio * side_);
    for (size_t w = 0; w < windows_.size(); ++w) {
      const size_t pictures = windows_[w]->pictures;
      double* pose = &state[first_pose_[w]];
      double* const depths = pose + kPose * (pictures - 1);
      double parallax = 0.0;
      for (size_t k = 1; k < pictures; ++k, pose += kPose) {
        const TwoViewMotion motion = EstimateTwoViewMotion(PairsOf(*windows_[w], k), camera, {});
        const Eigen::AngleAxisd turn(motion.rotation);
        parallax = std::max(motion.mean_parallax, kLeastParallax);
        AsVector(pose) = turn.angle() * turn.axis();
        AsVector(pose + 3) = parallax * motion.translation;
      }
      for (pose = &state[first_pose_[w]]; pose != depths; pose += kPose) {
        AsVector(pose + 3) /= parallax;
      }
      std::fill_n(depths, windows_[w]->tracks.size(), parallax);
    }
    return state;
  }

  // (BA4) from `state` on; returns its value, NaN where there is none.
  double Minimise(double noise, State& state) const {
    ceres::Problem problem;
    Build(noise, state, problem);
    ceres::Solver::Options options;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (const Observation& at : observations_) {
      options.linear_solver_ordering->AddElementToGroup(&state[at.inverse_depth], 0);
      options.linear_solver_ordering->AddElementToGroup(&state[at.pose], 1);
    }
    options.linear_solver_ordering->AddElementToGroup(state.data(), 1);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = kIterations;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return summary.IsSolutionUsable() ? summary.final_cost : std::nan("");
  }

  // sigma of the residuals, of which |e| has a Rayleigh distribution.
  double Noise(const State& state) const {
    std::vector<double> lengths;
    for (const Observation& at : observations_) {
      double e[2];
      if (ReprojectionOf(at, 1.0)(state.data(), &state[at.pose], &state[at.inverse_depth], e)) {
        lengths.push_back(std::hypot(e[0], e[1]));
      }
    }
    if (lengths.empty()) return kStartNoisePixels;
    return std::clamp(MedianInPlace(lengths) / std::sqrt(2.0 * std::log(2.0)), kLeastNoisePixels,
                      kStartNoisePixels);
  }

  // Covariance of the lens at the optimum of (BA4); nothing where it cannot be computed.
  std::optional<Eigen::Matrix2d> LensCovariance(double noise, State& state) const {
    ceres::Problem problem;
    Build(noise, state, problem);
    ceres::Problem::EvaluateOptions options;
    problem.GetParameterBlocks(&options.parameter_blocks);
    std::sort(options.parameter_blocks.begin(), options.parameter_blocks.end());
    ceres::CRSMatrix rows;
    if (!problem.Evaluate(options, nullptr, nullptr, nullptr, &rows)) return std::nullopt;
    const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> jacobian(
        rows.num_rows, rows.num_cols, static_cast<Eigen::Index>(rows.values.size()),
        rows.rows.data(), rows.cols.data(), rows.values.data());
    Eigen::SparseMatrix<double> normal = jacobian.transpose() * jacobian;
    for (int k = 0; k < normal.cols(); ++k) normal.coeffRef(k, k) += kLeastInformation;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(normal);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(normal.cols(), kLens);
    return factor.solve(unit).topRows<kLens>();
  }

 private:
  static constexpr int kLens = 2, kPose = 6;         // unknowns
  static constexpr double kLeastParallax = 1e-3;     // that the search begins with
  static constexpr double kLeastInformation = 1e-9;  // of unknowns that no place tells

  static Eigen::Map<Eigen::Vector3d> AsVector(double* three) {
    return Eigen::Map<Eigen::Vector3d>(three);
  }

  static std::vector<PointPair> PairsOf(const TrackWindow& window, size_t k) {
    std::vector<PointPair> pairs;
    for (const auto& track : window.tracks) {
      if (track.size() > k) pairs.push_back({track[0].x, track[0].y, track[k].x, track[k].y});
    }
    return pairs;
  }

  Reprojection ReprojectionOf(const Observation& at, double noise) const {
    return {at.start, at.seen, side_, noise};
  }

  void Build(double noise, State& state, ceres::Problem& problem) const {
    std::vector<int64_t> counts(windows_.size(), 0);
    for (const Observation& at : observations_) ++counts[at.window];
    std::vector<ceres::LossFunction*> losses;
    for (const int64_t count : counts) {
      losses.push_back(new ceres::ScaledLoss(
          new ceres::CauchyLoss(kCauchyScale),
          TwoViewMotion::kIndependentPairs / static_cast<double>(count), ceres::TAKE_OWNERSHIP));
    }
    for (const Observation& at : observations_) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Reprojection, 2, kLens, kPose, 1>(
                                   new Reprojection(ReprojectionOf(at, noise))),
                               losses[at.window], state.data(), &state[at.pose],
                               &state[at.inverse_depth]);
    }
    for (size_t w = 0; w < windows_.size(); ++w) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<ScaleGauge, 1, kPose>(new ScaleGauge), nullptr,
          &state[first_pose_[w] + kPose * (windows_[w]->pictures - 2)]);
    }
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<LensPrior, 2, kLens>(new LensPrior),
                             nullptr, state.data());
  }

  std::vector<const TrackWindow*> windows_;
  cv::Size image_;
  double side_;
  std::vector<size_t> first_pose_;  // one per window, in the State
  std::vector<Observation> observations_;
  size_t size_ = 0;  // of the State
};

}  // namespace

AdjustedLens AdjustLens(const std::vector<TrackWindow>& windows, cv::Size image) {
  std::vector<const TrackWindow*> usable;
  for (const TrackWindow& window : windows) {
    if (window.pictures >= 3 && window.tracks.size() >= kFewestTracks) usable.push_back(&window);
  }
  AdjustedLens lens;
  if (usable.empty()) return lens;
  const Adjustment adjustment(usable, image);
  State best;
  double least = std::numeric_limits<double>::infinity();
  for (const double ratio : kStartRatios) {
    State state = adjustment.Start(ratio);
    const double value = adjustment.Minimise(kStartNoisePixels, state);
    if (value < least) {
      least = value;
      best = std::move(state);
    }
  }
  if (best.empty()) return lens;
  const double noise = adjustment.Noise(best);
  if (std::isnan(adjustment.Minimise(noise, best))) return lens;
  const auto covariance = adjustment.LensCovariance(noise, best);
  if (!covariance) return lens;
  lens.focal_ratio = std::exp(best[0]);
  lens.log_focal_deviation = std::sqrt((*covariance)(0, 0));
  lens.radial = best[1];
  lens.radial_deviation = std::sqrt((*covariance)(1, 1));
  lens.noise_pixels = noise;
  lens.windows = static_cast<int>(usable.size());
  return lens;
}

}  // namespace egosieve::vision
