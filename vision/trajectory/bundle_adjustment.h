// Estimates the lens of a drive by bundle adjustment, its focal length and its radial distortion,
// together with the camera's motion in a few windows of pictures.
//
// Window w follows points i through its pictures k = 0..K (corner_tracks.h). With c the principal
// point, f the focal length, k1 the radial distortion and kappa its course, a ray (u, 1) is seen at
//
//   x(u) = c + f u (1 + z + kappa z^2),  z = k1 |u|^2                                       (BA1)
//   X_ik = R_k (u(x_i0), 1) + r_i t_k           r_i inverse depth                           (BA2)
//   e_ik = x(X_ik[0..1] / X_ik[2]) - x_ik       pixels                                      (BA3)
//
// The adjustment minimises, over f, k1, kappa, R_k, t_k and r_i of all windows,
//
//   sum_w M / n_w sum_ik rho(|e_ik|^2 / sigma^2) / 2 + (|t_K| - 1)^2 / (2 0.1^2)
//     - log t_3((log(f / L) - log 0.7) / 0.4)
//     + k1^2 / (2 0.2^2) + (kappa - 1.2)^2 / (2 0.8^2)                                      (BA4)
//
// L is the longer side of the image. rho is Cauchy's loss, 4 log(1 + z / 4), since movers are
// outliers. sigma is estimated from the residuals. The points of one window share the errors of
// tracker and model, so its n_w observations count as M = 30 (two_view_motion.h,
// kIndependentPairs). Without rotation and parallax the prior of f decides: Student's t with 3
// degrees of freedom. It covers dash-cams, phones and camcorders, and telephoto lenses in its
// tails.
//
// (BA4) has many local minima, and most of them come from the motion of a single window. At a fixed
// f the windows are independent. So each window is first solved alone for focal lengths from 0.35 L
// to 3.5 L. It starts from its motions by pairs of pictures and from its solutions at the
// neighbouring focal lengths. All windows are then adjusted together from the best of these f.
// Windows with a sigma of more than half a pixel are dropped, since most of their points do not
// show one rigid scene, and the rest is adjusted once more.
//
// The deviations are those of the marginal normal distributions at the optimum.
//
// Distortion is a function of the angle, so that k1, and with it its prior, does not depend on the
// focal length. kappa is k2 / k1^2 of the polynomial. Calibrations of KITTI's cameras have k1 = -0.37,
// kappa = 1.5, of EuRoC's -0.28 and 0.9, of GoPros -0.25 and 1.4; kappa is 1.8 of an ideal fisheye, and 0 of
// COLMAP's SIMPLE_RADIAL.
//
// Of four cameras three are taken to correct their pictures: k1 = 0. The drive is adjusted with k1
// and without. With k1 only counts where the data make k1 = 0 so much less likely than the prior of
// (BA4) has it (Savage and Dickey's ratio of densities),
//
//   p(k1 = 0 | data) < p(k1 = 0) / 3                                                        (BA5)
//
// where the data's deviation of k1 is taken for twice as large: over 33 clips of DAVIS, most of
// them hand-held, k1 scatters about 0 by 2.0 of its deviations. The left side is the larger one of
// two: by the normal distribution at the optimum, and by how much less (BA4) is there than where
// k1 = 0 and all else is adjusted again. Far from the optimum the first can be wrong by orders. Where a camera drives straight on,
// its distortion is not told, and does no harm: along the lines through the middle nothing bends.
//
// References: Triggs, McLauchlan, Hartley & Fitzgibbon (2000); Hartley & Zisserman, 2nd ed., 19.
// Ceres solves each problem on one thread, so that the result is the same each time.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/geometry/lens.h"

namespace egosieve::vision {

// Points of one window. track[k] is the point's position in picture k, in pixels. A track begins in
// picture 0 and may end before the last picture.
struct TrackWindow {
  int pictures = 0;
  std::vector<std::vector<cv::Point2d>> tracks;
};

struct AdjustedLens {
  double focal_ratio = 0.7;          // f / L
  double log_focal_deviation = 0.4;  // of log f
  double k1 = 0.0;                   // negative: a barrel
  double course = 0.0;               // kappa
  double noise_pixels = 0.0;         // sigma
  int windows = 0;                   // windows used; 0: the values above are the prior's
};

// image: size of the pictures. kNone: k1 is 0. Windows of fewer than 3 pictures or 20 tracks are
// not used, nor those without a track through all pictures.
enum class Distortion { kNone, kRadial };
AdjustedLens AdjustLens(const std::vector<TrackWindow>& windows, cv::Size image,
                        Distortion distortion = Distortion::kRadial);

// Of pictures of this size.
Lens LensOf(const AdjustedLens& adjusted, cv::Size image);

}  // namespace egosieve::vision
