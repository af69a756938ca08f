// Maps of a sequence linked along the pictures' motion, so that every frame's map rests on its
// neighbours' too, from both sides or from the past alone.
//
//   z_t         log odds of the map at time t; w_t = 1 where frame t has a map of its own, else 0
//   W_st        sampling of frame s at the places that frame t's pixels have there, by dense flow
//   k_st        exp(-e^2 / (2 tolerance^2)), e the flow's forward-backward error in pixels
//   q_st        exp(-|t - s| / memory_seconds)
//   N_t         = w_t z_t + q k W(N_{t-1}),   D_t = w_t + q k W(D_{t-1}): the past   (TL1)
//   N'_t, D'_t  the same from the future                                                     (TL2)
//   linked_t    = (N_t + N'_t - w_t z_t) / (D_t + D'_t - w_t)                                (TL3)
//
// A weighted mean of log odds, weights falling off with time and where flow does not hold: at a cut
// nothing is taken over. A frame without a map of its own, such as the first, gets its neighbours';
// where these say nothing either its log odds are 0.
#ifndef EGOSIEVE_VISION_MASKS_TEMPORAL_LINK_H_
#define EGOSIEVE_VISION_MASKS_TEMPORAL_LINK_H_

#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "vision/features/flow_grid.h"

namespace egosieve::vision {

struct TemporalLinkOptions {
  double memory_seconds = 0.6;    // positive
  double tolerance_pixels = 1.0;  // of the forward-backward error; positive
  bool causal = false;            // (TL1) alone

  absl::Status Validate() const;
};

// e^2 of k above, along `flow.forward` and along `flow.backward`.
struct ReturnErrors {
  cv::Mat1f forward, backward;  // pixels^2
};

struct LinkFrame {
  double time_seconds = 0.0;
  cv::Mat1f log_odds;
  bool has_map = true;
  // Between the frame before (first) and this one (second); empty: nothing is taken over.
  FlowPair flow;
  ReturnErrors errors;  // ReturnErrorsOf(flow)
};

// Empty where the flow is.
ReturnErrors ReturnErrorsOf(const FlowPair& flow);

// How well flow holds at each pixel of the side `from` starts at: k above.
cv::Mat1f FlowAgreement(const cv::Mat& from, const cv::Mat& back, double tolerance_pixels);

// values, sampled at x + flow(x); the nearest border pixel outside the image.
cv::Mat WarpByFlow(const cv::Mat& values, const cv::Mat& flow, int interpolation);

// Frames of one size, in the order of time. linked_t for each.
std::vector<cv::Mat1f> LinkMaps(const std::vector<LinkFrame>& frames,
                                const TemporalLinkOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MASKS_TEMPORAL_LINK_H_
