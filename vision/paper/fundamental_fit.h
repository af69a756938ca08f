// The fundamental matrix of pairs of points, of which some are false matches and some lie on things
// that move by themselves, by OpenCV's RANSAC (USAC): a truncated sum of squares (MSAC; Torr &
// Zisserman, 2000), local optimisation (Chum et al., 2003), dominant planes recognised (Chum et
// al., 2005) and least squares at the end.
//
//   cost(F) = sum_i min(d_i^2 / T^2, 1),   d Sampson's distance, T = 0.25 pixels
//
// All pairs are read; at most 2,000 samples are drawn. Same pairs and seed: same bytes.
//
// It is trusted where at least 0.3 of the pairs lie within 2 pixels of it: only a large share of them
// tells the camera's motion from a thing's.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/geometry/motion_model.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

// Kind kNone with a reason for fewer than 7 pairs of finite coordinates, and for pairs that do not
// determine a matrix: all points of an image on a line, identical, ...
MotionModel FitFundamental(const std::vector<PointPair>& pairs, uint64_t seed);

}  // namespace egosieve::vision
