// The focal length of a drive by bundle adjustment, together with the camera's motion in a few
// windows of pictures.
//
// Window w follows points i through its pictures k = 0..K (corner_tracks.h). With c the principal
// point and f the focal length,
//
//   v_ik = (x_ik - c) / f                                                                   (BA1)
//   X_ik = R_k (v_i0, 1) + r_i t_k              r_i inverse depth                           (BA2)
//   e_ik = c + f X_ik[0..1] / X_ik[2] - x_ik    pixels                                      (BA3)
//
// the adjustment minimises, over f, R_k, t_k and r_i of all windows,
//
//   sum_w M / n_w sum_ik rho(|e_ik|^2 / sigma^2) / 2 + (|t_K| - 1)^2 / (2 0.1^2)
//     - log t_3((log(f / L) - log 0.7) / 0.4)                                               (BA4)
//
// L is the image's longer side and rho Cauchy's, 4 log(1 + z / 4): movers are outliers. sigma is
// estimated from the residuals. Places of one window share the errors of tracker and model, so its
// n_w observations count as M = 30 (two_view_motion.h, kIndependentPairs). Where nothing turns and
// nothing has parallax the prior decides: Student's t with 3 degrees of freedom. It holds
// dash-cams (0.4 to 0.65), KITTI (0.58), phones (0.7 to 0.8) and camcorders (0.8 to 1.5), and in
// its tails telephoto lenses.
//
// (BA4) has many local minima, most of them by the motion of a single window. At a fixed f the
// windows are independent, so each is first solved alone for focal lengths from 0.35 L to 3.5 L,
// from its motions by pairs of pictures and from its solutions at the neighbouring focal lengths.
// From the best of these f all are adjusted together, and once more without those with a sigma of
// more than half a pixel: most of their places do not show one rigid world.
//
// The deviation is that of the marginal normal distribution of log f at the optimum.
//
// References: Triggs, McLauchlan, Hartley & Fitzgibbon (2000); Hartley & Zisserman, 2nd ed., 19.
// Solved by Ceres, each problem on one thread, so that the result is the same each time.
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
  double noise_pixels = 0.0;         // sigma
  int windows = 0;                   // that took part; 0: the values above are the prior's
};

// image: size of the pictures. Windows of fewer than 3 pictures or 20 tracks take no part, either.
AdjustedLens AdjustLens(const std::vector<TrackWindow>& windows, cv::Size image);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_BUNDLE_ADJUSTMENT_H_
