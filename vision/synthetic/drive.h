// Motion of vehicles and people: a path in the plane and a speed over time.
//
//   (DR1) path   straight pieces and arcs, joined smoothly, with lateral shifts o(s) laid over them
//                (s: arc length of the pieces): p(s) = base(s) + o(s) normal(s)
//   (DR2) speed  piecewise linear in time between keys, constant before the first and after the
//                last
//   (DR3) s(t)   = s_0 + integral of (DR2): exact, quadratic between keys
//
// Everything is a closed form of t, so that any frame can be rendered without the frames before it.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <utility>
#include <vector>

namespace egosieve::vision {

struct PathPoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double heading_radians = 0.0;  // from the x axis, counter-clockwise

  Eigen::Vector2d Forward() const { return {std::cos(heading_radians), std::sin(heading_radians)}; }
};

class Path {
 public:
  Path() = default;
  Path(const Eigen::Vector2d& start, double heading_radians)
      : pieces_{{{start, heading_radians}}} {}

  Path& Straight(double length_metres) { return Append(length_metres, 0.0); }
  // Left for positive angles.
  Path& Turn(double radius_metres, double angle_radians) {
    return Append(std::abs(angle_radians) * radius_metres,
                  (angle_radians < 0.0 ? -1.0 : 1.0) / radius_metres);
  }
  // Moves to the left by `offset_metres` between arc lengths `from` and `to`.
  Path& Shift(double from, double to, double offset_metres);

  // Beyond its ends the path continues straight.
  PathPoint At(double s) const;

 private:
  struct Piece {
    PathPoint start;
    double begin = 0.0;  // arc length
    double length = 0.0;
    double curvature = 0.0;  // signed, 1/m
  };
  struct LateralShift {
    double from, to, offset;
  };
  Path& Append(double length, double curvature);

  std::vector<Piece> pieces_ = {{}};  // the first has no length
  std::vector<LateralShift> shifts_;
};

struct SpeedKey {
  double seconds = 0.0;
  double metres_per_second = 0.0;
};

struct DriveState {
  PathPoint pose;
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  // metres per second
  double speed = 0.0;
  double travelled = 0.0;  // metres since t = 0; negative before
};

class Drive {
 public:
  Drive() = default;
  // Keys in order of time; without keys it stands still. `start` is the arc length at t = 0.
  Drive(Path path, double start, std::vector<SpeedKey> keys)
      : path_(std::move(path)), start_(start) {
    if (!keys.empty()) keys_ = std::move(keys);
  }

  DriveState At(double seconds) const;
  double Speed(double seconds) const;      // (DR2)
  double Travelled(double seconds) const;  // (DR3), minus s_0

 private:
  double Integral(double seconds) const;  // of (DR2), from the first key

  Path path_;
  double start_ = 0.0;
  std::vector<SpeedKey> keys_ = {{}};
};

}  // namespace egosieve::vision
