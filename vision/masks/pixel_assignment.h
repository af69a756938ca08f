// Assigns each pixel of the mask to a known mover: the one that best explains where the pixel comes
// from, where it goes, its colour, and where that mover was.
//
//   y_k(x)   position of x in the previous picture if it moved as mover k does (mover_motion.h);
//            u_k = x - y_k
//   P_k      the smaller of |I(x) - I_before(y_k)| and |I(x) - I_after(x + u_k)|, means over
//            5 x 5 pixels: a pixel that is occluded in one picture is seen in the other
//   M_k      distances between u_k and the flow to either side, each weighted by how well flow and
//            its return agree
//   D_k      distance of y_k from the pixels that k had
//   C_k      log of the largest share that any mover has of x's colour over the share that k has
//   cost_k   mean over 5 x 5 pixels of the mask of min(P_k / kLevels, 3) + min(M_k / kPixels, 3)
//            + min(D_k / kDistance, 2) + min(C_k, 2)                                       (PX1)
//
// A pixel takes the mover with the smallest cost if that is below kNewCost, else none. Each mover
// is moved by its own motion, not by the flow of its pixels: flow is smooth, and numbers that
// follow it spread from a mover to the one behind it.
//
// References: Jojic & Frey (2001), layers; Rhemann et al. (2011), filtering of costs.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/features/flow_grid.h"
#include "vision/masks/mover_motion.h"
#include "vision/masks/temporal_link.h"

namespace egosieve::vision {

inline constexpr int kMoverColours = 512;
using ColourShares = std::array<double, kMoverColours>;

inline int ColourOf(const cv::Vec3b& pixel) {
  return (pixel[0] >> 5) * 64 + (pixel[1] >> 5) * 8 + (pixel[2] >> 5);
}

// Bhattacharyya's distance, in [0, 1].
double ColourDistance(const ColourShares& a, const ColourShares& b);

// All of one size.
struct AssignmentPictures {
  TrackedFrame before, now, after;  // after: may be empty
  cv::Mat1b mask;
};

struct KnownMover {
  uint16_t number = 0;
  MoverMotion motion;  // from before to now
  const ColourShares* colours = nullptr;
};

// last: numbers in the previous picture. Returns the number of each pixel of the mask, 0 where no
// mover explains it.
cv::Mat1w AssignPixels(const AssignmentPictures& pictures, const cv::Mat1w& last,
                       const std::vector<KnownMover>& movers);

}  // namespace egosieve::vision
