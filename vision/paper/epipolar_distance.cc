#include "vision/paper/epipolar_distance.h"

#include <cmath>

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

}  // namespace egosieve::vision
