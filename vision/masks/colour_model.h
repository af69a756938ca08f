// The colours of moving and of static pixels of a shot.
//
//   c(x)      Lab colour, 0 to 255 per axis, in bins of 4
//   F         mixture of kParts Gaussians, fitted to c(x) with weights p^3                     (C1)
//   G         the same with weights (1 - p)^3 b, b = kFar max(p * g) + p * g, g a Gaussian of
//             deviation kAroundMovers times the longer side: the static pixels around the movers    (C2)
//   evidence  k log(F(c) / G(c)), clamped to [-limit, limit], k = s / (s + kSupportPixels), s the
//             smaller of the sums of p^3 and of (1 - p)^3: 0 without pixels of both kinds      (C3)
//
// Pixels with p near 0 or 1 count, others hardly. What is static around the movers is what they
// have to be told from. The mixtures are fitted by expectation maximisation, from parts that the
// widest part's longest axis divides; the variances are enlarged by kSpread, for noise.
//
// References: Orchard & Bouman, Color quantization of images (1991), for the first parts; Rother, Kolmogorov & Blake, GrabCut (2004), for mixtures as a term of a
// segmentation; Papazoglou & Ferrari, Fast object segmentation in unconstrained video (2013), for
// one model per shot.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

// (C3) of each picture of a shot. colours: Lab, of one size; probability: of moving, of the same
// size; limit: positive. Cost: linear in the pixels.
std::vector<cv::Mat1f> ColourEvidence(const std::vector<cv::Mat3b>& colours,
                                      const std::vector<cv::Mat1f>& probability, float limit);

}  // namespace egosieve::vision
