// Fusion of residuals into one probability.
//
// The log-likelihood ratios, dynamic against static, are those of calibrated_pairs.h and
// road_contact.h. A place that flow loses, but where the pictures show standing road
// (guided_match.h), has that of a distance z = 0 from its line, in deviations, where static points
// follow Student's t with 3 degrees of freedom and movers Cauchy's density of scale S = 15,
//
//   l = log c(0) / S - log t_3(0) = log(sqrt(3) / (2 S))                                     (F1)
//
// Along a track the ratios of each term are summed with forgetting,
//
//   A <- lambda A + l                                                                        (F2)
//   L = sum_terms log(h + (1 - h) exp(kappa A))                                              (F3)
//
// kappa < 1 because neighbouring frames share positions and therefore errors. h is the share of
// movers that a term cannot detect in any number of frames: cars along the epipolar line, cars at
// constant speed. It limits a term's evidence for static (to log h), not its evidence for dynamic.
// lambda, kappa and h are properties of the estimator, not of a drive. With pi the share of movers
//
//   p = 1 / (1 + exp(-L - log(pi / (1 - pi))))                                                (F4)
//   pi <- mean of p                                                                           (F5)
//
// (F5) is the step of expectation maximisation for the mixing weight, tracked over the frames. The
// mean is over all judged points, blank ones too: (F4) holds for all of them, and there are fewer
// movers among them than among textured points.
#pragma once

#include <array>
#include <cmath>
#include <vector>

namespace egosieve::vision {

enum class EvidenceTerm { kEpipolar, kRoad };
inline constexpr int kEvidenceTerms = 2;

// epipolar, road.
const char* Name(EvidenceTerm term);

inline const double kStandingLogRatio = std::log(std::sqrt(3.0) / 30.0);        // (F1)
inline constexpr std::array<double, kEvidenceTerms> kHiddenShare = {0.3, 0.0};  // h
inline constexpr double kLeastEvidence = 0.1;                                   // nats

// One term of (F3), from kappa A.
double VisibleLogRatio(EvidenceTerm term, double ratio);

// (F4).
double ProbabilityOf(double log_ratio, double mover_share);

// Whether |L| of (F4) is at least kLeastEvidence. Blank places, and such as look alike wherever they
// might have come from, tell nothing: their p is pi.
bool Tells(double probability, double mover_share);

// (F5) from `start` to convergence, within [0.01, 0.5]; `start` in that range if there are no
// ratios.
double EstimateMoverShare(const std::vector<double>& log_ratios, double start);

}  // namespace egosieve::vision
