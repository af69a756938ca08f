#include "vision/trajectory/bundle_adjustment.h"

#include <ceres/ceres.h>

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

#include "kernels/base/parallel_for.h"
#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/geometry/relative_pose.h"
#include "vision/statistics/order_statistics.h"
#include "vision/trajectory/bundle_adjustment_terms.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {
namespace {

constexpr double kDistortedShare = 0.25;
constexpr double kScatter = 2.0;  // of k1, in its deviations
constexpr double kDistrust = kScatter * kScatter;
constexpr double kDistortionPrior = 1.0 / (kDistortionDeviation * kDistortionDeviation);
constexpr double kCauchyScale = 2.0;
constexpr double kStartNoisePixels = 1.0, kLeastNoisePixels = 0.1, kMostNoisePixels = 0.5;
constexpr size_t kFewestTracks = 20;
constexpr int kIterations = 50, kWindowIterations = 15;
constexpr std::array<double, 7> kStartRatios = {0.35, 0.5, 0.75, 1.1, 1.6, 2.4, 3.5};  // f / L
constexpr int kPose = 6, kLens = 3;         // unknowns per picture, and of all pictures
constexpr double kLeastParallax = 1e-3;     // at the start of the search
constexpr double kLeastInformation = 1e-9;  // added for unknowns that no point determines

// All unknowns in one array, so that their order in memory, by which Ceres orders them, is always
// the same: log(f / L), k1, kappa, then window by window the poses of pictures 1..K and the inverse depths.
using State = std::vector<double>;

struct Observation {
  size_t pose = 0, inverse_depth = 0;  // in the State
  cv::Point2d start, seen;             // as in Reprojection
};

struct Window {
  const TrackWindow* tracks = nullptr;
  size_t first_pose = 0, first_depth = 0, end = 0;  // in the State
  std::vector<Observation> observations;

  size_t last_pose() const { return first_depth - kPose; }
};

Eigen::Map<Eigen::Vector3d> AsVector(double* three) { return Eigen::Map<Eigen::Vector3d>(three); }

class Adjustment {
 public:
  Adjustment(const std::vector<const TrackWindow*>& windows, cv::Size image)
      : image_(image), side_(std::max(image.width, image.height)) {
    const cv::Point2d centre(0.5 * (image.width - 1), 0.5 * (image.height - 1));
    for (const TrackWindow* tracks : windows) {
      Window& window = windows_.emplace_back();
      window.tracks = tracks;
      window.first_pose = size_;
      window.first_depth = size_ + kPose * (tracks->pictures - 1);
      window.end = size_ = window.first_depth + tracks->tracks.size();
      for (size_t i = 0; i < tracks->tracks.size(); ++i) {
        const auto& track = tracks->tracks[i];
        for (size_t k = 1; k < track.size(); ++k) {
          window.observations.push_back({window.first_pose + kPose * (k - 1),
                                         window.first_depth + i, track[0] - centre,
                                         track[k] - centre});
        }
      }
    }
  }

  // The best of the windows' solutions at the focal lengths kStartRatios.
  State Search() const {
    constexpr size_t kRatios = kStartRatios.size();
    std::vector<State> states(kRatios, NewState());
    std::vector<std::vector<double>> values(windows_.size(), std::vector<double>(kRatios));
    for (size_t j = 0; j < kRatios; ++j) states[j][0] = std::log(kStartRatios[j]);
    kernels::ParallelFor(static_cast<int64_t>(windows_.size()), [&](int64_t w) {
      const Window& window = windows_[w];
      const auto improve = [&](size_t j, State candidate) {
        const double value = MinimiseWindow(window, candidate);
        if (!(value < values[w][j])) return;
        values[w][j] = value;
        std::copy(candidate.begin() + window.first_pose, candidate.begin() + window.end,
                  states[j].begin() + window.first_pose);
      };
      for (size_t j = 0; j < kRatios; ++j) {
        values[w][j] = std::numeric_limits<double>::infinity();
        improve(j, ByPairs(window, kStartRatios[j]));
        if (j > 0)
          improve(j, Rescaled(window, states[j - 1], kStartRatios[j] / kStartRatios[j - 1]));
      }
      for (size_t j = kRatios - 1; j-- > 0;) {
        improve(j, Rescaled(window, states[j + 1], kStartRatios[j] / kStartRatios[j + 1]));
      }
    });
    size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < kRatios; ++j) {
      const double z = (states[j][0] - std::log(AdjustedLens().focal_ratio)) / kLogFocalScale;
      double value = 2.0 * std::log1p(z * z / 3.0);
      for (size_t w = 0; w < windows_.size(); ++w) value += values[w][j];
      if (value < least) {
        least = value;
        best = j;
      }
    }
    return states[best];
  }

  // Minimises (BA4) starting from `state`; returns its value, NaN where there is none.
  double Minimise(Distortion distortion, double noise, State& state) const {
    ceres::Problem problem;
    AddAll(distortion, noise, state, problem);
    return Solve(problem, kIterations, windows_.data(), windows_.size(), state);
  }

  // Drops the windows that no rigid scene explains. Returns whether any are left.
  bool DropNoisyWindows(const State& state) {
    std::erase_if(windows_, [&](const Window& window) {
      return !(NoiseOf(&window, 1, state) < kMostNoisePixels);
    });
    return !windows_.empty();
  }

  int windows() const { return static_cast<int>(windows_.size()); }

  double Noise(const State& state) const {
    return std::max(NoiseOf(windows_.data(), windows_.size(), state), kLeastNoisePixels);
  }

  // The variances of log(f / L) and k1 at the optimum of (BA4); nothing where they cannot be
  // computed.
  std::optional<Eigen::Vector2d> LensVariances(Distortion distortion, double noise,
                                               State& state) const {
    ceres::Problem problem;
    AddAll(distortion, noise, state, problem);
    ceres::Problem::EvaluateOptions options;
    problem.GetParameterBlocks(&options.parameter_blocks);
    std::erase_if(options.parameter_blocks,
                  [&](const double* block) { return problem.IsParameterBlockConstant(block); });
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
    const auto variance = [&](int k) {
      return Eigen::VectorXd(factor.solve(Eigen::VectorXd::Unit(normal.cols(), k)))(k);
    };
    return Eigen::Vector2d(variance(0), distortion == Distortion::kNone ? 0.0 : variance(1));
  }

 private:
  State NewState() const {
    State state(size_, 0.0);
    state[2] = kCourse;
    return state;
  }

  // sigma of the residuals: their lengths |e| have a Rayleigh distribution.
  double NoiseOf(const Window* windows, size_t count, const State& state) const {
    std::vector<double> lengths;
    for (const Window* window = windows; window != windows + count; ++window) {
      for (const Observation& at : window->observations) {
        double e[2];
        Reprojection{at.start, at.seen, side_, 1.0}(&state[0], &state[1], &state[at.pose],
                                                    &state[at.inverse_depth], e);
        lengths.push_back(std::hypot(e[0], e[1]));
      }
    }
    return MedianInPlace(lengths) / std::sqrt(2.0 * std::log(2.0));
  }

  // A state with the focal length and the unknowns of this window set, motions and depths by pairs
  // of pictures. Other windows are zero.
  State ByPairs(const Window& window, double focal_ratio) const {
    State state = NewState();
    state[0] = std::log(focal_ratio);
    const Pinhole camera = Pinhole::Of(image_, focal_ratio * side_);
    double parallax = 0.0;
    for (int k = 1; k < window.tracks->pictures; ++k) {
      std::vector<PointPair> pairs;
      for (const auto& track : window.tracks->tracks) {
        if (static_cast<int>(track.size()) <= k) continue;
        pairs.push_back({track[0].x, track[0].y, track[k].x, track[k].y});
      }
      const TwoViewMotion motion = EstimateTwoViewMotion(pairs, camera, {});
      const Eigen::AngleAxisd turn(motion.rotation);
      double* pose = &state[window.first_pose + kPose * (k - 1)];
      parallax = std::max(motion.mean_parallax, kLeastParallax);
      AsVector(pose) = turn.angle() * turn.axis();
      AsVector(pose + 3) = parallax * motion.translation;
    }
    for (size_t pose = window.first_pose; pose < window.first_depth; pose += kPose) {
      AsVector(&state[pose + 3]) /= parallax;
    }
    std::fill(state.begin() + window.first_depth, state.begin() + window.end, parallax);
    return state;
  }

  // The state that gives nearly the same image points at `ratio` times the focal length.
  State Rescaled(const Window& window, State state, double ratio) const {
    state[0] += std::log(ratio);
    for (size_t pose = window.first_pose; pose < window.first_depth; pose += kPose) {
      state[pose] /= ratio;
      state[pose + 1] /= ratio;
      state[pose + 5] *= ratio;
    }
    const double scale = AsVector(&state[window.last_pose() + 3]).norm();
    if (!(scale > 0.0)) return state;
    for (size_t pose = window.first_pose; pose < window.first_depth; pose += kPose) {
      AsVector(&state[pose + 3]) /= scale;
    }
    for (size_t i = window.first_depth; i < window.end; ++i) state[i] *= scale / ratio;
    return state;
  }

  // Minimises the window's part of (BA4) at a fixed focal length.
  double MinimiseWindow(const Window& window, State& state) const {
    ceres::Problem problem;
    Add(window, kStartNoisePixels, state, problem);
    problem.SetParameterBlockConstant(&state[0]);
    problem.SetParameterBlockConstant(&state[1]);
    return Solve(problem, kWindowIterations, &window, 1, state);
  }

  static double Solve(ceres::Problem& problem, int iterations, const Window* windows, size_t count,
                      State& state) {
    ceres::Solver::Options options;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    ceres::ParameterBlockOrdering& order = *options.linear_solver_ordering;
    for (const Window* window = windows; window != windows + count; ++window) {
      for (const Observation& at : window->observations) {
        order.AddElementToGroup(&state[at.inverse_depth], 0);
        order.AddElementToGroup(&state[at.pose], 1);
      }
    }
    order.AddElementToGroup(&state[0], 1);
    order.AddElementToGroup(&state[1], 1);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = iterations;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return summary.IsSolutionUsable() ? summary.final_cost : std::nan("");
  }

  void Add(const Window& window, double noise, State& state, ceres::Problem& problem) const {
    auto* loss = new ceres::ScaledLoss(
        new ceres::CauchyLoss(kCauchyScale),
        TwoViewMotion::kIndependentPairs / static_cast<double>(window.observations.size()),
        ceres::TAKE_OWNERSHIP);
    for (const Observation& at : window.observations) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Reprojection, 2, 1, 2, kPose, 1>(
                                   new Reprojection{at.start, at.seen, side_, noise}),
                               loss, &state[0], &state[1], &state[at.pose],
                               &state[at.inverse_depth]);
    }
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ScaleGauge, 1, kPose>(new ScaleGauge),
                             nullptr, &state[window.last_pose()]);
  }

  void AddAll(Distortion distortion, double noise, State& state, ceres::Problem& problem) const {
    for (const Window& window : windows_) Add(window, noise, state, problem);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<FocalPrior, 1, 1>(new FocalPrior),
                             StudentThree(), &state[0]);
    if (distortion == Distortion::kNone) return problem.SetParameterBlockConstant(&state[1]);
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<DistortionPrior, 2, 2>(new DistortionPrior), nullptr,
        &state[1]);
  }

  cv::Size image_;
  double side_;
  std::vector<Window> windows_;
  size_t size_ = kLens;  // of the State
};

// (BA5), where k1 = 0 is less likely than the optimum by so many nats. trusted: the information of
// the drive's data on k1, as far as it is trusted.
bool IsDistorted(double trusted, double nats) {
  return std::sqrt(1.0 + trusted / kDistortionPrior) * std::exp(-nats) <
         kDistortedShare / (1.0 - kDistortedShare);
}

// The value of (BA4) with k1 = 0. It has many minima: from the optimum with k1 and from where the
// search ended.
double ValueWithoutDistortion(const Adjustment& adjustment, double noise, State optimum,
                              State searched) {
  optimum[1] = 0.0;
  return std::min(adjustment.Minimise(Distortion::kNone, noise, optimum),
                  adjustment.Minimise(Distortion::kNone, noise, searched));
}

// From where the search ended. Nothing where no window shows a rigid scene, or with k1 where the
// data do not prove it.
std::optional<AdjustedLens> Solve(Adjustment adjustment, const State& searched,
                                  Distortion distortion) {
  State state = searched;
  const double start = adjustment.Minimise(distortion, kStartNoisePixels, state);
  if (!adjustment.DropNoisyWindows(state)) return std::nullopt;
  const double noise = adjustment.Noise(state);
  const double value = adjustment.Minimise(distortion, noise, state);
  const std::optional<Eigen::Vector2d> variances =
      adjustment.LensVariances(distortion, noise, state);
  if (std::isnan(start + value) || !variances) return std::nullopt;
  const AdjustedLens lens{
      std::exp(state[0]),  std::sqrt((*variances)(0)), state[1], state[2], noise,
      adjustment.windows()};
  if (distortion == Distortion::kNone) return lens;
  const double information = 1.0 / (*variances)(1);
  const double trusted = (information - kDistortionPrior) / kDistrust;
  const double pull = lens.k1 * information / kDistrust;
  if (!IsDistorted(trusted, 0.5 * pull * pull / (trusted + kDistortionPrior))) return std::nullopt;
  const double without = ValueWithoutDistortion(adjustment, noise, state, searched);
  if (!IsDistorted(trusted, (without - value) / kDistrust)) return std::nullopt;
  return lens;
}

}  // namespace

AdjustedLens AdjustLens(const std::vector<TrackWindow>& windows, cv::Size image,
                        Distortion distortion) {
  std::vector<const TrackWindow*> usable;
  for (const TrackWindow& window : windows) {
    // Where no track reaches the last picture, nothing tells its pose.
    const bool is_whole = std::any_of(window.tracks.begin(), window.tracks.end(),
                                      [&](const std::vector<cv::Point2d>& track) {
                                        return static_cast<int>(track.size()) == window.pictures;
                                      });
    if (window.pictures >= 3 && is_whole && window.tracks.size() >= kFewestTracks) {
      usable.push_back(&window);
    }
  }
  if (usable.empty()) return {};
  const Adjustment adjustment(usable, image);
  const State start = adjustment.Search();
  if (distortion == Distortion::kRadial) {
    if (const auto distorted = Solve(adjustment, start, distortion)) return *distorted;
  }
  return Solve(adjustment, start, Distortion::kNone).value_or(AdjustedLens());
}

Lens LensOf(const AdjustedLens& adjusted, cv::Size image) {
  const double side = std::max(image.width, image.height);
  const double focal = adjusted.focal_ratio * side;
  Lens lens{focal, focal, 0.5 * image.width, 0.5 * image.height};
  lens.distortion[0] = adjusted.k1;
  lens.distortion[1] = adjusted.course * adjusted.k1 * adjusted.k1;
  return lens;
}

}  // namespace egosieve::vision
