#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "vision/paper/block_score.h"
#include "vision/paper/ransac_model.h"
#include "vision/paper/seven_point.h"

namespace egosieve::vision {
namespace {

void SquaredSampson(const FloatMatrix& f, const NormalizedPairs& pairs, int64_t begin, int count,
                    float* out) {
  const float* x1 = pairs.x1.data() + begin;
  const float* y1 = pairs.y1.data() + begin;
  const float* x2 = pairs.x2.data() + begin;
  const float* y2 = pairs.y2.data() + begin;
  constexpr float kTiny = 1e-30F;
  for (int i = 0; i < count; ++i) {
    const float a = f.m[0] * x1[i] + f.m[1] * y1[i] + f.m[2];
    const float b = f.m[3] * x1[i] + f.m[4] * y1[i] + f.m[5];
    const float c = f.m[6] * x1[i] + f.m[7] * y1[i] + f.m[8];
    const float d = f.m[0] * x2[i] + f.m[3] * y2[i] + f.m[6];
    const float g = f.m[1] * x2[i] + f.m[4] * y2[i] + f.m[7];
    const float e = a * x2[i] + b * y2[i] + c;
    out[i] = e * e / (a * a + b * b + d * d + g * g + kTiny);
  }
}

}  // namespace

void FundamentalModel::Solve(const NormalizedPairs& pairs, const int64_t (&sample)[kSampleSize],
                             std::vector<Eigen::Matrix3d>& models) {
  std::array<PointPair, 7> seven;
  for (int i = 0; i < 7; ++i) seven[i] = pairs.pair(sample[i]);
  const SevenPointSolutions solutions = SolveSevenPoint(seven);
  for (int i = 0; i < solutions.count; ++i) {
    if (OrientationsAgree(solutions.matrices[i], seven)) models.push_back(solutions.matrices[i]);
  }
}

Score FundamentalModel::Evaluate(const Eigen::Matrix3d& matrix, const NormalizedPairs& pairs,
                                 int64_t begin, int64_t end, double threshold) {
  const FloatMatrix f(matrix);
  return ScoreInBlocks(begin, end, threshold, [&](int64_t start, int count, float* squares) {
    SquaredSampson(f, pairs, start, count, squares);
  });
}

bool FundamentalModel::Refine(const NormalizedPairs& pairs, double radius, Eigen::Matrix3d& f) {
  const FloatMatrix current(f);
  const double inverse = 1.0 / (radius * radius);
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  int64_t used = 0;
  float squares[kPairsPerBlock];
  for (int64_t start = 0; start < pairs.size(); start += kPairsPerBlock) {
    const int count = static_cast<int>(std::min<int64_t>(kPairsPerBlock, pairs.size() - start));
    SquaredSampson(current, pairs, start, count, squares);
    for (int i = 0; i < count; ++i) {
      const double relative = squares[i] * inverse;
      if (!(relative < 1.0)) continue;
      const double x1 = pairs.x1[start + i], y1 = pairs.y1[start + i];
      const double x2 = pairs.x2[start + i], y2 = pairs.y2[start + i];
      const double a = f(0, 0) * x1 + f(0, 1) * y1 + f(0, 2);
      const double b = f(1, 0) * x1 + f(1, 1) * y1 + f(1, 2);
      const double d = f(0, 0) * x2 + f(1, 0) * y2 + f(2, 0);
      const double g = f(0, 1) * x2 + f(1, 1) * y2 + f(2, 1);
      const double gradient = a * a + b * b + d * d + g * g;
      if (!(gradient > 0.0)) continue;
      const double weight = (1.0 - relative) * (1.0 - relative) / gradient;
      Eigen::Matrix<double, 9, 1> row;
      row << x2 * x1, x2 * y1, x2, y2 * x1, y2 * y1, y2, x1, y1, 1.0;
      normal.noalias() += (weight * row) * row.transpose();
      ++used;
    }
  }
  if (used < kMinimumForRefinement) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(normal);
  if (eigen.info() != Eigen::Success) return false;
  const Eigen::Matrix<double, 9, 1> solution = eigen.eigenvectors().col(0);
  Eigen::Matrix3d full;
  full << solution(0), solution(1), solution(2), solution(3), solution(4), solution(5), solution(6),
      solution(7), solution(8);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(full, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d singular = svd.singularValues();
  singular(2) = 0.0;
  const Eigen::Matrix3d refined = svd.matrixU() * singular.asDiagonal() * svd.matrixV().transpose();
  const double norm = refined.norm();
  if (!(norm > 0.0) || !std::isfinite(norm)) return false;
  f = refined / norm;
  return true;
}

}  // namespace egosieve::vision
