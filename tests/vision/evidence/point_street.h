// A street of points seen by a camera on a car: exact places in every frame, with noise on request.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/tracking/grid_tracker.h"

namespace egosieve::vision {

struct StreetOptions {
  cv::Size size{1242, 375};
  double focal_pixels = 720;
  int static_count = 600, mover_count = 0;
  Eigen::Vector3d travel{0.02, 0.0, 1.0};       // of the camera, metres a frame (x right, z ahead)
  Eigen::Vector3d mover_travel{0.0, 0.0, 1.6};  // of the movers, metres a frame
  double yaw = 0.004;                           // radians a frame
  double pitch = 0.0015;                        // amplitude, alternating
  double noise_pixels = 0.0;
  uint64_t seed = 1;
};

class PointStreet {
 public:
  explicit PointStreet(const StreetOptions& options)
      : options_(options), camera_(Pinhole::Of(options.size, options.focal_pixels)) {
    std::mt19937_64 random(options.seed);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    for (int i = 0; i < options.static_count + options.mover_count; ++i) {
      const bool moves = i >= options.static_count;
      const double depth = moves ? uniform(10, 30) : 8.0 / uniform(0.08, 1.0);
      const double x = uniform(0, options.size.width - 1), y = uniform(0, options.size.height - 1);
      points_.push_back(depth * camera_.Ray(x, y));
    }
  }

  int64_t size() const { return points_.size(); }
  bool moves(int64_t i) const { return i >= options_.static_count; }
  const Pinhole& camera() const { return camera_; }

  // Place of point i in frame t; NaN behind the camera.
  Eigen::Vector2d Place(int64_t i, int t) const {
    Eigen::Vector3d world = points_[i];
    if (moves(i)) world += t * options_.mover_travel;
    const Eigen::Vector3d seen = Rotation(t) * (world - t * options_.travel);
    if (!(seen(2) > 0.5)) return Eigen::Vector2d::Constant(std::nan(""));
    std::mt19937_64 random(options_.seed * 7919 + i * 104729 + t);
    Eigen::Vector2d noise;
    for (int k = 0; k < 2; ++k) {
      double sum = -6.0;  // Irwin and Hall's approximation of a normal number
      for (int n = 0; n < 12; ++n) sum += static_cast<double>(random() >> 11) * 0x1p-53;
      noise(k) = options_.noise_pixels * sum;
    }
    return camera_.Project(seen) + noise;
  }

  Eigen::Matrix3d Rotation(int t) const {
    const double pitch = t % 2 == 0 ? options_.pitch : -options_.pitch;
    return (Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) *
            Eigen::AngleAxisd(options_.yaw * t, Eigen::Vector3d::UnitY()))
        .toRotationMatrix();
  }
  // X_b = R X_a + t between frames a and b.
  Eigen::Matrix3d RotationBetween(int a, int b) const {
    return Rotation(b) * Rotation(a).transpose();
  }
  Eigen::Vector3d TranslationBetween(int a, int b) const {
    return Rotation(b) * ((a - b) * options_.travel);
  }
  bool Inside(const Eigen::Vector2d& p) const {
    return p(0) >= 0 && p(1) >= 0 && p(0) <= options_.size.width - 1 &&
           p(1) <= options_.size.height - 1;
  }
  PointPair Pair(int64_t i, int a, int b) const {
    const Eigen::Vector2d p = Place(i, a), q = Place(i, b);
    return {p(0), p(1), q(0), q(1)};
  }
  // Points seen in both frames; `indices` gets which.
  std::vector<PointPair> Pairs(int a, int b, std::vector<int64_t>* indices = nullptr) const {
    std::vector<PointPair> pairs;
    for (int64_t i = 0; i < size(); ++i) {
      if (!Inside(Place(i, a)) || !Inside(Place(i, b))) continue;
      pairs.push_back(Pair(i, a, b));
      if (indices != nullptr) indices->push_back(i);
    }
    return pairs;
  }
  // Tracks of all points inside in frame t, ids are the points' indices, from `start` on.
  std::vector<Track> Tracks(int t, int start = 0) const {
    std::vector<Track> tracks;
    for (int64_t i = 0; i < size(); ++i) {
      Track track{.id = i};
      for (int k = t; k >= start; --k) {
        const Eigen::Vector2d p = Place(i, k);
        if (!Inside(p)) break;
        if (track.length < kTrackHistory) track.places[track.length] = cv::Point2f(p(0), p(1));
        ++track.length;
      }
      if (track.length > 1) track.parent_id = i;
      if (track.length > 0) tracks.push_back(track);
    }
    return tracks;
  }

 private:
  StreetOptions options_;
  Pinhole camera_;
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace egosieve::vision
