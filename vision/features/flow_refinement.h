// Variational refinement of dense flow.
//
// Around a flow f, every pixel has three lines in the plane of displacements u: brightness and both
// components of the gradient do not change. With A = (I + J(x + f)) / 2 and D = J(x + f) - I,
//
//   D + grad A . (u - f) = 0,   D_x + grad A_x . (u - f) = 0,   D_y + grad A_y . (u - f) = 0
//
// Their distances from u, in pixels, and the gradients of u are charged by their lengths:
//
//   E(u) = sum_x  5 r_0 + 10 r_1 + 20 |grad u|                                              (FR1)
//
// r_0 the distance from the first line, r_1 the root of the sum of squares of the others. A line of
// a gradient g counts by |g|^2 / (|g|^2 + .01): a blank place has none. The least squares of (FR1)
// are weighted again in each round, and solved by sweeps of successive over-relaxation.
//
// The charges are those of OpenCV's DIS. Reference: Brox, Bruhn, Papenberg & Weickert, High accuracy
// optical flow estimation based on a theory for warping (ECCV 2004).
#pragma once

#include <opencv2/core.hpp>

#include "vision/features/flow_patch.h"

namespace egosieve::vision {

// flow: from `from` to `to`, of their size. rounds: not negative.
void RefineFlow(const FlowPicture& from, const FlowPicture& to, int rounds, cv::Mat2f& flow);

}  // namespace egosieve::vision
