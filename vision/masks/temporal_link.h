// Links the maps of a sequence along the motion of the pictures, so that every frame's map also
// uses those of its neighbours, from both sides or only from the past.
//
//   z_t         log odds of the map at time t; w_t = 1 where frame t has a map of its own, else 0
//   W_st        samples frame s at the positions of frame t's pixels, by dense flow
//   k_st        exp(-e^2 / (2 kTolerancePixels^2)), e the flow's forward-backward error in pixels
//   q_st        exp(-|t - s| / memory_seconds)
//   N_t         = w_t z_t + q k W(N_{t-1}),   D_t = w_t + q k W(D_{t-1}): the past   (TL1)
//   N'_t, D'_t  the same from the future                                                     (TL2)
//   linked_t    = (N_t + N'_t - w_t z_t) / (D_t + D'_t - w_t)                                (TL3)
//
// This is a weighted mean of log odds. The weights decrease with time and where flow does not hold,
// and nothing is taken over at a cut. A frame without a map of its own, such as the first, gets
// those of its neighbours; where these have no weight either, its log odds are 0.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/features/flow_grid.h"

namespace egosieve::vision {

struct TemporalLinkOptions {
  double memory_seconds = 0.6;  // positive
  bool causal = false;          // (TL1) alone
};

inline constexpr double kTolerancePixels = 0.3;  // of the forward-backward error

// e^2 of k above, along `flow.forward` and along `flow.backward`.
struct ReturnErrors {
  cv::Mat1f forward, backward;  // pixels^2
};

// A picture of a sequence of one size, at working resolution (edge_refinement.h).
struct TrackedFrame {
  double time_seconds = 0.0;
  cv::Mat3b image;
  // Between the previous frame (first) and this one (second); empty: nothing leads from there.
  FlowPair flow;
  ReturnErrors errors;  // ReturnErrorsOf(flow)
};

// The picture itself is not read by the link.
struct LinkFrame : TrackedFrame {
  cv::Mat1f log_odds;  // of the map
  bool has_map = true;
};

// Empty where the flow is empty.
ReturnErrors ReturnErrorsOf(const FlowPair& flow);

// k above, from squared errors of ReturnErrors.
cv::Mat1f AgreementOf(const cv::Mat1f& errors, double tolerance_pixels);

// Returns linked_t of each frame. The frames must have one size and be in the order of time.
std::vector<cv::Mat1f> LinkMaps(const std::vector<LinkFrame>& frames,
                                const TemporalLinkOptions& options);

}  // namespace egosieve::vision
