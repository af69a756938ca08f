// Finds the primitives that a ray may meet: those whose bounding boxes, projected along the rays to
// a plane, cover the ray's place there. The plane is divided into square cells, each with a list,
// and a query reads one cell.
//
//   view      Rays are o + t d with unit component of d along the optical axis, so that t is the
//             depth Z. The plane is the image, and lists are sorted by the smallest depth of the
//             boxes: once a hit is nearer than the next entry's depth, the rest of the list can be
//             skipped.
//   shadows   The line through P along the sun's direction meets the ground at
//
//               G = P - to_sun P_z / to_sun_z                                             (SG1)
//
//             Only those primitives can shade P whose box, projected along the same direction,
//             covers G.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "vision/synthetic/camera.h"

namespace egosieve::vision {

struct Candidate {
  int32_t primitive = 0;
  float depth = 0.0f;
};

class CandidateLists {
 public:
  // Nothing is listed outside `area`.
  CandidateLists(const Eigen::AlignedBox2d& area, double cell);
  void Add(const Eigen::AlignedBox2d& footprint, const Candidate& candidate);
  const std::vector<Candidate>& At(const Eigen::Vector2d& place) const;

 private:
  Eigen::AlignedBox2d area_;
  double cell_;
  int columns_, rows_;
  std::vector<std::vector<Candidate>> lists_;
  std::vector<Candidate> none_;
};

// The picture without distortion: a pinhole image that contains every pixel's ray.
struct PinholeView {
  Intrinsics intrinsics;
  int width = 0;
  int height = 0;
};

// By the view's pixels. Primitives are indices of `bounds`.
CandidateLists ListView(const std::vector<Eigen::AlignedBox3d>& bounds, const PinholeView& view,
                        const Pose& pose);

// (SG1).
Eigen::Vector2d ShadowPlace(const Eigen::Vector3d& point, const Eigen::Vector3d& to_sun);
// By (SG1), from the index `first` on.
CandidateLists ListShadows(const std::vector<Eigen::AlignedBox3d>& bounds, size_t first,
                           const Eigen::Vector3d& to_sun, const Eigen::AlignedBox2d& area);

}  // namespace egosieve::vision
