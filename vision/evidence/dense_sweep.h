// Dense evidence from grey levels: for every second pixel, whether the picture there is explained
// by a static point of some depth. It needs no smooth flow, and asks places that flow has lost.
//
// The sweep (kernels/ops/plane_sweep.h) with H = K R K^-1 and e = K t gives E_0, the least squared
// difference over the positions of a static point, and E_1, the one at the flow's place. As in
// photometric_support.h, with its noise sigma, N = 49, the patch P of the place and the mean squared
// gradient G of P,
//
//   l = kappa (E_0 - E_1) / (2 (v + sigma_p^2 G))                                           (DE1)
//
// is the log-likelihood ratio of moving against static; as (S2), but with either sign. Where flow
// gives no place, the place may be moving or hidden, and
//
//   E_1 = kMostChange |P|^2                                                               (DE2)
//
// is put in place of what was not found: a static place fits better than that, another surface does
// not (guided_match.h, GM1). Blank places abstain, with l = 0:
//
//   |P|^2 < N (kLeastTexture sigma)^2                                                       (DE3)
//
// and where flow gives no place, also those whose structure tensor T has its smaller eigenvalue
// below kLeastCorner trace T: a straight edge fits anywhere along itself. So do places whose patches
// leave the pictures.
//
// The inverse depths r_j, j < J, are equal steps of the signed flow s along the epipolar line
// (epipolar_line.h) from the point at infinity to the nearest depth:
//
//   s_j = j s_(J-1) / (J - 1),  J = ceil(s_(J-1) / step_pixels) + 1, at most `most_steps`   (DE4)
//
// at the corner of the picture where the flow is longest; elsewhere they are shorter. With
// fewer steps than asked for, E_0 is too high where the texture is finer than a step. The patch at
// r_j has pixels 1 / (1 + r_j t_3) apart, the size of a static point's surroundings there.
#ifndef EGOSIEVE_VISION_EVIDENCE_DENSE_SWEEP_H_
#define EGOSIEVE_VISION_EVIDENCE_DENSE_SWEEP_H_

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "kernels/base/plane_sweep_inputs.h"
#include "kernels/runtime/context.h"
#include "vision/evidence/pinhole.h"

namespace egosieve::vision {

struct DenseSweepOptions {
  int stride = 2;            // pixels between places; at least 1
  double step_pixels = 1.0;  // positive
  int most_steps = 64;       // at least 1

  absl::Status Validate() const;
};

// Two grey pictures, CV_8UC1 of one size, and the camera's motion X_2 = R X_1 + t between them.
struct DenseSweepPair {
  cv::Mat before, now;
  // CV_32FC2, from `before` to `now` at the places of kernels::ImageGrid with the stride of the
  // options; NaN: lost.
  cv::Mat flow;
  Pinhole camera;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double most_inverse_depth = 0.0;  // of a static point, in units of 1 / t's; not negative
  double noise_levels = 1.5;        // sigma, of PhotometricSupport; positive
  double place_pixels = 0.0;        // sigma_p; not negative
};

// r_j with the scales. `options` must be valid.
std::vector<kernels::SweepStep> SweepStepsOf(const DenseSweepPair& pair,
                                             const DenseSweepOptions& options);

// l of each place, CV_32FC1 of the grid's size. InvalidArgument if the pair is not as described.
absl::StatusOr<cv::Mat> DenseSweepLogRatios(kernels::Context& context, const DenseSweepPair& pair,
                                            const DenseSweepOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_DENSE_SWEEP_H_
