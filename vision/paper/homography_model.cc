#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "vision/paper/block_score.h"
#include "vision/paper/ransac_model.h"

namespace egosieve::vision {
namespace {

constexpr double kRankTolerance = 1e-9;

// Twice the area of the triangle, signed.
double Area(double ax, double ay, double bx, double by, double cx, double cy) {
  return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
}

// No three points are collinear, and each triangle has the same orientation in both images.
bool IsProperSample(const NormalizedPairs& pairs, const int64_t (&s)[4]) {
  constexpr double kMinimumArea = 1e-4;
  constexpr int kTriangles[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  for (const auto& t : kTriangles) {
    const PointPair a = pairs.pair(s[t[0]]), b = pairs.pair(s[t[1]]), c = pairs.pair(s[t[2]]);
    const double first = Area(a.x1, a.y1, b.x1, b.y1, c.x1, c.y1);
    const double second = Area(a.x2, a.y2, b.x2, b.y2, c.x2, c.y2);
    if (!(std::abs(first) > kMinimumArea && std::abs(second) > kMinimumArea)) return false;
    if ((first > 0.0) != (second > 0.0)) return false;
  }
  return true;
}

void SquaredTransfer(const FloatMatrix& h, const NormalizedPairs& pairs, int64_t begin, int count,
                     float* out) {
  const float* x1 = pairs.x1.data() + begin;
  const float* y1 = pairs.y1.data() + begin;
  const float* x2 = pairs.x2.data() + begin;
  const float* y2 = pairs.y2.data() + begin;
  for (int i = 0; i < count; ++i) {
    const float w = 1.0F / (h.m[6] * x1[i] + h.m[7] * y1[i] + h.m[8]);
    const float dx = (h.m[0] * x1[i] + h.m[1] * y1[i] + h.m[2]) * w - x2[i];
    const float dy = (h.m[3] * x1[i] + h.m[4] * y1[i] + h.m[5]) * w - y2[i];
    out[i] = dx * dx + dy * dy;
  }
}

}  // namespace

void HomographyModel::Solve(const NormalizedPairs& pairs, const int64_t (&sample)[kSampleSize],
                            std::vector<Eigen::Matrix3d>& models) {
  if (!IsProperSample(pairs, sample)) return;
  Eigen::Matrix<double, 8, 8> a;
  Eigen::Matrix<double, 8, 1> b;
  for (int i = 0; i < 4; ++i) {
    const PointPair p = pairs.pair(sample[i]);
    a.row(2 * i) << p.x1, p.y1, 1.0, 0.0, 0.0, 0.0, -p.x2 * p.x1, -p.x2 * p.y1;
    a.row(2 * i + 1) << 0.0, 0.0, 0.0, p.x1, p.y1, 1.0, -p.y2 * p.x1, -p.y2 * p.y1;
    b(2 * i) = p.x2;
    b(2 * i + 1) = p.y2;
  }
  const Eigen::PartialPivLU<Eigen::Matrix<double, 8, 8>> lu(a);
  const double smallest = lu.matrixLU().diagonal().cwiseAbs().minCoeff();
  if (!(smallest > kRankTolerance)) return;
  const Eigen::Matrix<double, 8, 1> h = lu.solve(b);
  if (!h.allFinite()) return;
  Eigen::Matrix3d matrix;
  matrix << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), 1.0;
  models.push_back(matrix);
}

Score HomographyModel::Evaluate(const Eigen::Matrix3d& matrix, const NormalizedPairs& pairs,
                                int64_t begin, int64_t end, double threshold) {
  const FloatMatrix h(matrix);
  return ScoreInBlocks(begin, end, threshold, [&](int64_t start, int count, float* squares) {
    SquaredTransfer(h, pairs, start, count, squares);
  });
}

// A Gauss-Newton step in the eight entries of H other than h33 = 1.
bool HomographyModel::Refine(const NormalizedPairs& pairs, double radius, Eigen::Matrix3d& h) {
  const double inverse = 1.0 / (radius * radius);
  Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> right = Eigen::Matrix<double, 8, 1>::Zero();
  int64_t used = 0;
  for (int64_t i = 0; i < pairs.size(); ++i) {
    const double x = pairs.x1[i], y = pairs.y1[i];
    const double w = 1.0 / (h(2, 0) * x + h(2, 1) * y + h(2, 2));
    const double u = (h(0, 0) * x + h(0, 1) * y + h(0, 2)) * w;
    const double v = (h(1, 0) * x + h(1, 1) * y + h(1, 2)) * w;
    const double du = pairs.x2[i] - u, dv = pairs.y2[i] - v;
    const double relative = (du * du + dv * dv) * inverse;
    if (!(relative < 1.0)) continue;
    const double weight = (1.0 - relative) * (1.0 - relative);
    Eigen::Matrix<double, 8, 1> ju, jv;
    ju << x * w, y * w, w, 0.0, 0.0, 0.0, -u * x * w, -u * y * w;
    jv << 0.0, 0.0, 0.0, x * w, y * w, w, -v * x * w, -v * y * w;
    normal.noalias() += (weight * ju) * ju.transpose();
    normal.noalias() += (weight * jv) * jv.transpose();
    right += weight * (du * ju + dv * jv);
    ++used;
  }
  if (used < kMinimumForRefinement) return false;
  const Eigen::Matrix<double, 8, 1> step = normal.ldlt().solve(right);
  if (!step.allFinite()) return false;
  for (int i = 0; i < 8; ++i) h(i / 3, i % 3) += step(i);
  return true;
}

}  // namespace egosieve::vision
