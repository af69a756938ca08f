#include "tools/evaluation/trajectory_errors.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/json_fields.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::tools {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

struct NumberLine {
  int64_t line = 0;  // from 1
  std::vector<double> values;
};

// Lines of `count` numbers, separated by blanks; empty lines and comments are skipped.
absl::StatusOr<std::vector<NumberLine>> ParseNumbers(absl::string_view text, size_t count) {
  std::vector<NumberLine> parsed;
  int64_t number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    if (absl::StripAsciiWhitespace(line).empty() || line.front() == '#') continue;
    NumberLine own{number, {}};
    for (const absl::string_view word :
         absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty())) {
      double value = 0.0;
      if (!absl::SimpleAtod(word, &value) || !std::isfinite(value)) {
        return absl::DataLossError(absl::StrCat("line ", number, ": ", word, " is no number"));
      }
      own.values.push_back(value);
    }
    if (own.values.size() != count) {
      return absl::DataLossError(absl::StrCat("line ", number, ": ", own.values.size(),
                                              " numbers; there must be ", count));
    }
    parsed.push_back(std::move(own));
  }
  return parsed;
}

// The rotation nearest to a matrix; absent if its determinant is not positive.
std::optional<Eigen::Matrix3d> NearestRotation(const Eigen::Matrix3d& matrix) {
  if (!(matrix.determinant() > 0.0)) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

// acos loses half the digits near 0 and pi; atan2 of sine and cosine does not.
double RotationAngle(const Eigen::Matrix3d& rotation) {
  const Eigen::Vector3d axis(rotation(2, 1) - rotation(1, 2), rotation(0, 2) - rotation(2, 0),
                             rotation(1, 0) - rotation(0, 1));
  return std::atan2(axis.norm(), rotation.trace() - 1.0);
}

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  if (!(a.norm() > 0.0 && b.norm() > 0.0)) return 0.5 * M_PI;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

std::optional<double> MedianOf(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  return vision::InterpolatedMedian(std::move(values));
}

struct PosePair {
  double seconds = 0.0;  // of the truth
  CameraPose estimate, truth;
};

std::optional<double> RotationError(const std::vector<PosePair>& pairs, double span_seconds) {
  std::vector<double> errors;
  for (size_t i = 0; i < pairs.size(); ++i) {
    size_t j = i + 1;
    while (j < pairs.size() && pairs[j].seconds - pairs[i].seconds < span_seconds - 1e-9) ++j;
    if (j >= pairs.size()) break;
    const Eigen::Matrix3d estimate =
        pairs[i].estimate.rotation.transpose() * pairs[j].estimate.rotation;
    const Eigen::Matrix3d truth = pairs[i].truth.rotation.transpose() * pairs[j].truth.rotation;
    errors.push_back(kDegrees * RotationAngle(estimate.transpose() * truth) /
                     (pairs[j].seconds - pairs[i].seconds));
  }
  return MedianOf(std::move(errors));
}

std::vector<double> DirectionErrors(const std::vector<PosePair>& pairs,
                                    const TrajectoryErrorOptions& options) {
  std::vector<double> errors;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const PosePair& from = pairs[i];
    for (size_t j = i + 1; j < pairs.size(); ++j) {
      if (pairs[j].seconds - from.seconds > options.travel_seconds + 1e-9) break;
      const Eigen::Vector3d travel = pairs[j].truth.centre - from.truth.centre;
      if (!(travel.norm() > options.least_travel_metres)) continue;
      errors.push_back(kDegrees *
                       AngleBetween(from.estimate.rotation.transpose() *
                                        (pairs[j].estimate.centre - from.estimate.centre),
                                    from.truth.rotation.transpose() * travel));
      break;
    }
  }
  return errors;
}

}  // namespace

absl::StatusOr<std::vector<TimedPose>> ParseTumTrajectory(absl::string_view text) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<NumberLine> lines, ParseNumbers(text, 8));
  std::vector<TimedPose> poses;
  for (const auto& [line, v] : lines) {
    const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
    if (!(q.norm() > 0.0)) {
      return absl::DataLossError(absl::StrCat("line ", line, ": the quaternion is zero"));
    }
    poses.push_back({v[0], {q.normalized().toRotationMatrix(), {v[1], v[2], v[3]}}});
  }
  return poses;
}

absl::StatusOr<Trajectory> ParseKittiPoses(absl::string_view text) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<NumberLine> lines, ParseNumbers(text, 12));
  Trajectory trajectory;
  for (const auto& [line, v] : lines) {
    Eigen::Matrix3d matrix;
    matrix << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
    const std::optional<Eigen::Matrix3d> rotation = NearestRotation(matrix);
    if (!rotation) {
      return absl::DataLossError(absl::StrCat("line ", line, ": its matrix is no rotation"));
    }
    trajectory[static_cast<int64_t>(trajectory.size())] = {*rotation, {v[3], v[7], v[11]}};
  }
  return trajectory;
}

Trajectory ByFrame(const std::vector<TimedPose>& poses,
                   const std::map<int64_t, double>& frame_seconds) {
  double step = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, int64_t>> times;
  for (const auto& [frame, seconds] : frame_seconds) {
    if (!times.empty()) step = std::min(step, seconds - times.back().first);
    times.push_back({seconds, frame});
  }
  Trajectory trajectory;
  for (const TimedPose& pose : poses) {
    const auto behind = std::upper_bound(times.begin(), times.end(),
                                         std::pair(pose.seconds - 0.5 * step, int64_t{0}));
    if (behind != times.end() && std::abs(behind->first - pose.seconds) < 0.5 * step) {
      trajectory[behind->second] = pose.pose;
    }
  }
  return trajectory;
}

absl::Status TrajectoryErrorOptions::Validate() const {
  if (!(frames_per_second > 0.0) || !(span_seconds > 0.0) || !(least_travel_metres >= 0.0) ||
      !(travel_seconds > 0.0)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "frames_per_second = %g, span_seconds = %g, least_travel_metres = %g, travel_seconds = %g; "
        "they must be positive (the third: not negative)",
        frames_per_second, span_seconds, least_travel_metres, travel_seconds));
  }
  return absl::OkStatus();
}

TrajectoryErrors CompareTrajectories(const Trajectory& estimate, const Trajectory& truth,
                                     const TrajectoryErrorOptions& options) {
  std::vector<PosePair> pairs;
  for (const auto& [frame, pose] : truth) {
    const auto found = estimate.find(frame);
    if (found == estimate.end()) continue;
    pairs.push_back({static_cast<double>(frame) / options.frames_per_second, found->second, pose});
  }
  TrajectoryErrors errors;
  errors.frames = static_cast<int64_t>(pairs.size());
  errors.rotation = RotationError(pairs, options.span_seconds);
  errors.rotation_neighbours = RotationError(pairs, 0.0);
  std::vector<double> directions = DirectionErrors(pairs, options);
  errors.travelling = static_cast<int64_t>(directions.size());
  errors.direction = MedianOf(std::move(directions));
  return errors;
}

absl::StatusOr<CameraTruth> ParseCamera(absl::string_view json) {
  const nlohmann::ordered_json parsed =
      nlohmann::ordered_json::parse(json.begin(), json.end(), nullptr, false);
  CameraTruth camera;
  double rate = 0.0;
  JsonFields fields(parsed, "the camera");
  fields.Read("focal_pixels", camera.focal_pixels);
  fields.Read("width", camera.width);
  fields.Read("height", camera.height);
  fields.ReadIfThere("radial", camera.radial);
  fields.ReadIfThere("frames_per_second", rate);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  if (!(camera.focal_pixels > 0.0) || !(camera.width > 0.0)) {
    return absl::DataLossError(
        absl::StrFormat("the camera: focal_pixels = %g, width = %g; they "
                        "must be positive",
                        camera.focal_pixels, camera.width));
  }
  if (rate > 0.0) camera.frames_per_second = rate;
  return camera;
}

double FocalErrorPercent(const CameraTruth& estimate, const CameraTruth& truth) {
  return 100.0 * (estimate.focal_pixels / estimate.width) / (truth.focal_pixels / truth.width) -
         100.0;
}

}  // namespace egosieve::tools
