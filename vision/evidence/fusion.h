// Fusion of residuals into one probability.
//
// All residuals come as z = r / deviation. The deviation is the term's own, estimated from the
// static majority. Static points follow Student's t with 3 degrees of freedom, whose tails allow
// for occasional bad positions. Movers lie anywhere, on a scale of S deviations. Log-likelihood
// ratios, dynamic against static:
//
//   distance    l(z) = log c(|z| / S) / S - log t_3(|z|),  c Cauchy's density                  (F1)
//   depth       l(z) = max(0, -log 2 T_3(z)),              T_3 the distribution function       (F2)
//
// The road's ratio is that of road_contact.h. (F2): the depth of a static point is uniform over all
// positive depths, that of a mover over both signs; so a positive depth is no evidence. Along a
// track the ratios of each term are summed with forgetting,
//
//   A <- lambda A + l                                                                        (F3)
//   L = sum_terms log(h + (1 - h) exp(kappa A))                                              (F4)
//
// kappa < 1 because neighbouring frames share positions and therefore errors. h is the share of
// movers that a term cannot detect in any number of frames: cars along the epipolar line, cars at
// constant speed. It limits a term's evidence for static (to log h), not its evidence for dynamic.
// lambda, kappa and h are properties of the estimator, not of a drive. With pi the share of movers
//
//   p = 1 / (1 + exp(-L - log(pi / (1 - pi))))                                                (F5)
//   pi <- mean of p                                                                           (F6)
//
// (F6) is the step of expectation maximisation for the mixing weight, tracked over the frames. The
// mean is over all judged points, blank ones too: (F5) holds for all of them, and there are fewer
// movers among them than among textured points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace egosieve::vision {

enum class EvidenceTerm { kEpipolar, kNegativeDepth, kRoad };
inline constexpr int kEvidenceTerms = 3;

// epipolar, negative_depth, road.
const char* Name(EvidenceTerm term);

inline constexpr double kMoverScale = 15.0;                                          // S
inline constexpr std::array<double, kEvidenceTerms> kHiddenShare = {0.3, 0.0, 0.0};  // h
inline constexpr double kLeastEvidence = 0.1;                                        // nats

// (F1), (F2); 0 if z is NaN.
double DistanceLogRatio(double z);
double DepthLogRatio(double z);

// Distribution function of Student's t with 3 degrees of freedom.
double StudentThree(double z);

// One term of (F4), from kappa A.
double VisibleLogRatio(EvidenceTerm term, double ratio);

// (F5).
double ProbabilityOf(double log_ratio, double mover_share);

// Whether |L| of (F5) is at least kLeastEvidence. Blank places, and such as look alike wherever they
// might have come from, tell nothing: their p is pi.
bool Tells(double probability, double mover_share);

// (F6) from `start` to convergence, within [0.01, 0.5]; `start` in that range if there are no
// ratios.
double EstimateMoverShare(const std::vector<double>& log_ratios, double start);

}  // namespace egosieve::vision
