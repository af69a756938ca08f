// Scores of ransac.h from squared distances in float32, in blocks of pairs in plain arrays, so that
// the compiler vectorises distances and sums.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>

#include "vision/paper/ransac_model.h"

namespace egosieve::vision {

inline constexpr int kPairsPerBlock = 64;

// Row by row.
struct FloatMatrix {
  float m[9];
  explicit FloatMatrix(const Eigen::Matrix3d& matrix) {
    for (int i = 0; i < 9; ++i) m[i] = static_cast<float>(matrix(i / 3, i % 3));
  }
};

// The score of the pairs [begin, end). squared_distances(start, count, squares) writes the squared
// distances of `count` pairs from `start` on, at most kPairsPerBlock.
template <typename SquaredDistances>
Score ScoreInBlocks(int64_t begin, int64_t end, double threshold,
                    SquaredDistances squared_distances) {
  const float inverse = static_cast<float>(1.0 / (threshold * threshold));
  Score score;
  float squares[kPairsPerBlock];
  for (int64_t start = begin; start < end; start += kPairsPerBlock) {
    const int count = static_cast<int>(std::min<int64_t>(kPairsPerBlock, end - start));
    squared_distances(start, count, squares);
    float cost = 0.0F;
    int inliers = 0;
    for (int i = 0; i < count; ++i) {
      const float relative = squares[i] * inverse;
      cost += relative < 1.0F ? relative : 1.0F;
      inliers += relative < 1.0F ? 1 : 0;
    }
    score.cost += cost;
    score.inlier_count += inliers;
  }
  return score;
}

}  // namespace egosieve::vision
