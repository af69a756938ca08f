// Probabilistic least-squares classification: turns a regression's predictions into probabilities
// (paper, eq. 6; Rasmussen & Williams, 6.5 and eq. 6.41, whose square root is missing in the
// paper).
//
//   p(t = +1 | x) = Phi( (a mu + b) / sqrt(1 + a^2 s^2) )                              (LS1)
//
// a, b maximise the leave-one-out likelihood. A label p_i in [0, 1] weights both classes, and
// (mu_i, s_i^2) is the prediction of point i without point i:
//
//   l(a, b) = sum_i  p_i log Phi(z_i) + (1 - p_i) log Phi(-z_i),
//   z_i = (a mu_i + b) / sqrt(1 + a^2 s_i^2)                                           (LS2)
//
// If the points are not a representative sample of the inputs to predict, weights w and v multiply
// the two terms of each point: w = desired share of the class / its share in the sample, v likewise
// for the other class.
//
// l is unbounded in a on separable data, so a is kept in [0.3, 10] and b in [-5, 5]. s^2 is
// the variance of f, both in the fit and in the prediction.
#pragma once

#include "absl/status/statusor.h"
#include "absl/types/span.h"

namespace egosieve::gp {

// log Phi(z) and its derivative phi(z) / Phi(z), without underflow.
struct LogDistribution {
  double value;
  double derivative;
};
LogDistribution LogNormalDistribution(double z);

struct SquashParameters {
  double a = 1.0;
  double b = 0.0;

  // (LS1).
  double Probability(double mean, double variance) const;
};

// Maximises (LS2) from `start`, with a Gaussian prior on log a around 0, of standard deviation 2, for
// data that do not determine a (one class only, separable classes). Without points: `start`, clamped to
// the bounds. InvalidArgument for sizes that differ, a start with a <= 0 or not finite, labels outside
// [0, 1], negative or non-finite variances, non-finite means. class_share: share of +1 among the inputs
// to predict, in (0, 1); 0: that of the points.
absl::StatusOr<SquashParameters> FitSquash(absl::Span<const double> means,
                                           absl::Span<const double> variances,
                                           absl::Span<const double> labels,
                                           const SquashParameters& start, double class_share = 0.0);

}  // namespace egosieve::gp
