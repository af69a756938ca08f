#include "vision/geometry/residual.h"

#include <cmath>
#include <limits>

namespace egosieve::vision {
namespace {

struct EpipolarTerms {
  double e = 0.0;
  double second = 0.0;  // squared norms of the lines' normals
  double first = 0.0;
};

EpipolarTerms Terms(const Eigen::Matrix3d& f, const PointPair& p) {
  const Eigen::Vector3d a(p.x1, p.y1, 1.0), b(p.x2, p.y2, 1.0);
  const Eigen::Vector3d line2 = f * a, line1 = f.transpose() * b;
  return {b.dot(line2), line2.head<2>().squaredNorm(), line1.head<2>().squaredNorm()};
}

double Ratio(double e, double squares) {
  return squares > 0.0 ? std::abs(e) / std::sqrt(squares) : 0.0;
}

}  // namespace

double SampsonDistance(const Eigen::Matrix3d& f, const PointPair& pair) {
  const EpipolarTerms terms = Terms(f, pair);
  return Ratio(terms.e, terms.first + terms.second);
}

double PointToLineDistance(const Eigen::Matrix3d& f, const PointPair& pair) {
  const EpipolarTerms terms = Terms(f, pair);
  return Ratio(terms.e, terms.second);
}

double TransferDistance(const Eigen::Matrix3d& h, const PointPair& pair) {
  const Eigen::Vector3d moved = h * Eigen::Vector3d(pair.x1, pair.y1, 1.0);
  const double x = moved(0) / moved(2) - pair.x2, y = moved(1) / moved(2) - pair.y2;
  const double distance = std::hypot(x, y);
  return std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity();
}

std::vector<double> Residuals(MotionModelKind kind, const Eigen::Matrix3d& matrix,
                              const std::vector<PointPair>& pairs, EpipolarDistance distance) {
  std::vector<double> residuals;
  residuals.reserve(pairs.size());
  for (const PointPair& pair : pairs) {
    double value = 0.0;
    switch (kind) {
      case MotionModelKind::kNone:
        break;
      case MotionModelKind::kStatic:
        value = std::hypot(pair.x2 - pair.x1, pair.y2 - pair.y1);
        break;
      case MotionModelKind::kHomography:
        value = TransferDistance(matrix, pair);
        break;
      case MotionModelKind::kFundamental:
        value = distance == EpipolarDistance::kSampson ? SampsonDistance(matrix, pair)
                                                       : PointToLineDistance(matrix, pair);
        break;
    }
    residuals.push_back(value);
  }
  return residuals;
}

}  // namespace egosieve::vision
