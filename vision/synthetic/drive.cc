#include "vision/synthetic/drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace egosieve::vision {
namespace {

Eigen::Vector2d Direction(double heading) { return {std::cos(heading), std::sin(heading)}; }

PathPoint Along(const PathPoint& start, double curvature, double length) {
  if (curvature == 0.0) {
    return {start.position + length * Direction(start.heading_radians), start.heading_radians};
  }
  const double heading = start.heading_radians + curvature * length;
  const Eigen::Vector2d chord(std::sin(heading) - std::sin(start.heading_radians),
                              std::cos(start.heading_radians) - std::cos(heading));
  return {start.position + chord / curvature, heading};
}

}  // namespace

Path::Path(const Eigen::Vector2d& start, double heading_radians) : start_{start, heading_radians} {}

PathPoint Path::End() const {
  if (pieces_.empty()) return start_;
  const Piece& last = pieces_.back();
  return Along(last.start, last.curvature, last.length);
}

Path& Path::Straight(double length_metres) {
  const double begin = pieces_.empty() ? 0.0 : pieces_.back().begin + pieces_.back().length;
  pieces_.push_back({End(), begin, length_metres, 0.0});
  return *this;
}

Path& Path::Turn(double radius_metres, double angle_radians) {
  const double begin = pieces_.empty() ? 0.0 : pieces_.back().begin + pieces_.back().length;
  const double curvature = (angle_radians < 0.0 ? -1.0 : 1.0) / radius_metres;
  pieces_.push_back({End(), begin, std::abs(angle_radians) * radius_metres, curvature});
  return *this;
}

Path& Path::Shift(double from, double to, double offset_metres) {
  shifts_.push_back({from, to, offset_metres});
  return *this;
}

PathPoint Path::At(double s) const {
  PathPoint point;
  if (pieces_.empty() || s < 0.0) {
    point = Along(start_, 0.0, s);
  } else {
    const Piece* piece = &pieces_.front();
    for (const Piece& candidate : pieces_) {
      if (s >= candidate.begin) piece = &candidate;
    }
    const double within = std::min(s - piece->begin, piece->length);
    point = Along(Along(piece->start, piece->curvature, within), 0.0, s - piece->begin - within);
  }
  double offset = 0.0, slope = 0.0;
  for (const LateralShift& shift : shifts_) {
    const double length = shift.to - shift.from;
    const double t = std::clamp((s - shift.from) / length, 0.0, 1.0);
    offset += shift.offset * t * t * (3.0 - 2.0 * t);
    slope += shift.offset * 6.0 * t * (1.0 - t) / length;
  }
  point.position += offset * Direction(point.heading_radians + M_PI / 2);
  point.heading_radians += std::atan(slope);
  return point;
}

Drive::Drive(Path path, double start, std::vector<SpeedKey> keys)
    : path_(std::move(path)), start_(start), keys_(std::move(keys)) {}

double Drive::Speed(double seconds) const {
  if (keys_.empty()) return 0.0;
  if (seconds <= keys_.front().seconds) return keys_.front().metres_per_second;
  for (size_t k = 1; k < keys_.size(); ++k) {
    if (seconds > keys_[k].seconds) continue;
    const double t = (seconds - keys_[k - 1].seconds) / (keys_[k].seconds - keys_[k - 1].seconds);
    return keys_[k - 1].metres_per_second +
           t * (keys_[k].metres_per_second - keys_[k - 1].metres_per_second);
  }
  return keys_.back().metres_per_second;
}

double Drive::Integral(double seconds) const {
  if (keys_.empty()) return 0.0;
  if (seconds <= keys_.front().seconds) {
    return (seconds - keys_.front().seconds) * keys_.front().metres_per_second;
  }
  double sum = 0.0;
  for (size_t k = 1; k < keys_.size(); ++k) {
    const double to = std::min(seconds, keys_[k].seconds);
    sum += 0.5 * (to - keys_[k - 1].seconds) * (keys_[k - 1].metres_per_second + Speed(to));
    if (seconds <= keys_[k].seconds) return sum;
  }
  return sum + (seconds - keys_.back().seconds) * keys_.back().metres_per_second;
}

double Drive::Travelled(double seconds) const { return Integral(seconds) - Integral(0.0); }

DriveState Drive::At(double seconds) const {
  DriveState state;
  state.travelled = Travelled(seconds);
  state.speed = Speed(seconds);
  const double s = start_ + state.travelled;
  state.pose = path_.At(s);
  constexpr double kStep = 1e-4;
  state.velocity =
      (path_.At(s + kStep).position - path_.At(s - kStep).position) * (state.speed / (2 * kStep));
  return state;
}

}  // namespace egosieve::vision
