// An exponential variable seen through Gaussian noise: the parallax of a static point whose inverse
// depth is distributed exponentially.
//
//   f(s) = integral_0^inf N(s; x, sigma^2) exp(-x / m) / m dx
//        = exp(k^2 / 2 - s / m) Phi(a) / m,   k = sigma / m,  a = s / sigma - k            (PP1)
//   (log f)'  = -1 / m + q / sigma,           q = phi(a) / Phi(a)                          (PP2)
//   (log f)'' = -q (q + a) / sigma^2                                                       (PP3)
//
// log f is concave in s.
#ifndef EGOSIEVE_VISION_TRAJECTORY_PARALLAX_PRIOR_H_
#define EGOSIEVE_VISION_TRAJECTORY_PARALLAX_PRIOR_H_

namespace egosieve::vision {

struct ParallaxDensity {
  double log_density = 0.0;
  double slope = 0.0;      // (PP2)
  double curvature = 0.0;  // minus (PP3), not negative
};

// mean, deviation: m and sigma, positive. Right to 1e-9 relative in log_density.
ParallaxDensity EvaluateParallax(double s, double mean, double deviation);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_PARALLAX_PRIOR_H_
