#include "vision/synthetic/drive.h"

#include <algorithm>

namespace egosieve::vision {
namespace {

PathPoint Along(const PathPoint& start, double curvature, double length) {
  if (curvature == 0.0) {
    return {start.position + length * start.Forward(), start.heading_radians};
  }
  const double heading = start.heading_radians + curvature * length;
  const Eigen::Vector2d chord(std::sin(heading) - std::sin(start.heading_radians),
                              std::cos(start.heading_radians) - std::cos(heading));
  return {start.position + chord / curvature, heading};
}

}  // namespace

Path& Path::Append(double length, double curvature) {
  const Piece& last = pieces_.back();
  pieces_.push_back({Along(last.start, last.curvature, last.length), last.begin + last.length,
                     length, curvature});
  return *this;
}

Path& Path::Shift(double from, double to, double offset_metres) {
  shifts_.push_back({from, to, offset_metres});
  return *this;
}

PathPoint Path::At(double s) const {
  const Piece* piece = &pieces_.front();
  for (const Piece& candidate : pieces_) {
    if (s >= candidate.begin) piece = &candidate;
  }
  const double within = std::min(s - piece->begin, piece->length);
  PathPoint point =
      Along(Along(piece->start, piece->curvature, within), 0.0, s - piece->begin - within);
  double offset = 0.0, slope = 0.0;
  for (const LateralShift& shift : shifts_) {
    const double length = shift.to - shift.from;
    const double t = std::clamp((s - shift.from) / length, 0.0, 1.0);
    offset += shift.offset * t * t * (3.0 - 2.0 * t);
    slope += shift.offset * 6.0 * t * (1.0 - t) / length;
  }
  point.position += offset * PathPoint{{}, point.heading_radians + M_PI / 2}.Forward();
  point.heading_radians += std::atan(slope);
  return point;
}

double Drive::Speed(double seconds) const {
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
