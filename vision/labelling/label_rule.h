// Label rules: from the distances d of matches to the motion model, in pixels, to probabilities p
// of being dynamic.
//
//   scaled distance   p = d / d_max; d > d_max is a false match and gets no label  (paper, III)
//   scaled median     p = min(1, d / (c s)),  s = max(floor, 1.48 median d)        (L1)
//   mixture           p = w u / (w u + (1 - w) g(d)); static: Gaussian of deviation sigma, dynamic:
//                     uniform within R                                             (L2)
//
// A match with long flow is located less accurately, because perspective distorts near objects and
// flow smooths them. The last two rules therefore take distances reduced to those of a match with
// short flow,
//
//   d / sqrt(1 + (k f / floor)^2),   f = |(x2, y2) - (x1, y1)|.                    (L0)
//
// Without it, errors of near objects hide movers that cross further away.
#ifndef EGOSIEVE_VISION_LABELLING_LABEL_RULE_H_
#define EGOSIEVE_VISION_LABELLING_LABEL_RULE_H_

#include <vector>

namespace egosieve::vision {

// (L0), in place; `lengths_pixels` are f, floor > 0.
void ReduceToShortFlow(const std::vector<double>& lengths_pixels, double share, double floor_pixels,
                       std::vector<double>& distances);

// (L1) for each distance; noise_pixels: s, by RobustScale of robust_scale.h, positive.
std::vector<double> ScaledMedianLabels(const std::vector<double>& distances, double noise_pixels,
                                       double multiple);

struct MixtureState {
  double noise_pixels = 0.0;   // sigma; 0: not estimated yet
  double dynamic_share = 0.0;  // w
};

struct MixtureOptions {
  int residual_dimension = 1;  // m: 1 for distances to lines, 2 to points
  double noise_floor_pixels = 0.1;
  double range_pixels = 30.0;  // R: the largest distance that counts
  double memory_share = 0.2;   // weight of the previous state, as a share of the frame's matches
  int iterations = 30;
};

struct MixtureLabels {
  std::vector<double> probability;
  MixtureState state;
};

// (L2) with sigma and w estimated by expectation maximisation from the distances and `previous`.
MixtureLabels EstimateMixtureLabels(const std::vector<double>& distances,
                                    const MixtureState& previous, const MixtureOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_LABEL_RULE_H_
