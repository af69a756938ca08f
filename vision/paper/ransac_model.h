// The two models of ransac.h in normalised coordinates: minimal solvers, scores and refinement.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/paper/normalized_pairs.h"

namespace egosieve::vision {

struct Score {
  double cost = 0.0;         // (RS1)
  int64_t inlier_count = 0;  // pairs with d < T
};

struct FundamentalModel {
  static constexpr int kSampleSize = 7;
  static constexpr int kMinimumForRefinement = 12;
  // Appends the sample's solutions to `models`.
  static void Solve(const NormalizedPairs& pairs, const int64_t (&sample)[kSampleSize],
                    std::vector<Eigen::Matrix3d>& models);
  // Scores the pairs [begin, end); threshold in normalised units.
  static Score Evaluate(const Eigen::Matrix3d& f, const NormalizedPairs& pairs, int64_t begin,
                        int64_t end, double threshold);
  // One reweighted step: pairs farther than `radius` have no weight. False if it fails.
  static bool Refine(const NormalizedPairs& pairs, double radius, Eigen::Matrix3d& f);
};

struct HomographyModel {
  static constexpr int kSampleSize = 4;
  static constexpr int kMinimumForRefinement = 8;
  static void Solve(const NormalizedPairs& pairs, const int64_t (&sample)[kSampleSize],
                    std::vector<Eigen::Matrix3d>& models);
  static Score Evaluate(const Eigen::Matrix3d& h, const NormalizedPairs& pairs, int64_t begin,
                        int64_t end, double threshold);
  static bool Refine(const NormalizedPairs& pairs, double radius, Eigen::Matrix3d& h);
};

}  // namespace egosieve::vision
