// The lens of a drive by bundle adjustment: one focal length and one coefficient of radial
// distortion, together with the camera's motion in a few windows of pictures.
//
// Window w follows points i through its pictures k = 0..K (corner_tracks.h). With c the principal
// point, f the focal length and kappa the distortion,
//
//   u      = (x - c) / f,  u = d(v) = v (1 + kappa |v|^2)         v without distortion        (BA1)
//   X_ik   = R_k (v_i0, 1) + r_i t_k                              r_i inverse depth           (BA2)
//   e_ik   = c + f d(X_ik[0..1] / X_ik[2]) - x_ik                 pixels                      (BA3)
//
// the adjustment minimises, over f, kappa, R_k, t_k and r_i of all windows,
//
//   sum_w M / n_w sum_ik rho(|e_ik|^2 / sigma^2) / 2 + (|t_K| - 1)^2 / (2 0.1^2)
//     + (log(f / L) - log 0.7)^2 / (2 0.4^2) + kappa^2 / (2 0.1^2)                            (BA4)
//
// L is the image's longer side and rho Cauchy's, 4 log(1 + z / 4): movers are outliers. sigma is
// estimated from the residuals. Places of one window share the errors of tracker and model, so its
// n_w observations count as M = 30 (two_view_motion.h, kIndependentPairs). Where nothing turns and
// nothing has parallax the priors decide. That of f holds dash-cams (0.4 to 0.65), KITTI (0.58),
// phones (0.7 to 0.8) and camcorders (0.8 to 1.5).
//
// The deviations are those of the marginal normal distribution of (log f, kappa) at the optimum.
//
// References: Triggs, McLauchlan, Hartley & Fitzgibbon (2000); Hartley & Zisserman, 2nd ed., 19.
// Solved by Ceres, on one thread, so that the result is the same each time.
#ifndef EGOSIEVE_VISION_TRAJECTORY_BUNDLE_ADJUSTMENT_H_
#define EGOSIEVE_VISION_TRAJECTORY_BUNDLE_ADJUSTMENT_H_

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

// Points of one window. track[k]: place in picture k, pixels; a track begins in picture 0 and may
// end before the last one.
struct TrackWindow {
  int pictures = 0;
  std::vector<std::vector<cv::Point2d>> tracks;
};

struct AdjustedLens {
  double focal_ratio = 0.7;          // f / L
  double log_focal_deviation = 0.4;  // of log f
  double radial = 0.0;               // kappa
  double radial_deviation = 0.1;
  double noise_pixels = 0.0;  // sigma
  int windows = 0;            // that took part; 0: the values above are the priors'
};

// image: size of the pictures. Windows of fewer than 3 pictures or 20 tracks take no part.
AdjustedLens AdjustLens(const std::vector<TrackWindow>& windows, cv::Size image);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_BUNDLE_ADJUSTMENT_H_
