#include "vision/paper/seven_point.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace egosieve::vision {
namespace {

constexpr double kLeastPivot = 1e-9;

using Constraints = Eigen::Matrix<double, 7, 9, Eigen::RowMajor>;
using Coefficients = Eigen::Matrix<double, 9, 1>;

Constraints BuildConstraints(const std::array<PointPair, 7>& pairs) {
  Constraints a;
  for (int i = 0; i < 7; ++i) {
    const PointPair& p = pairs[i];
    a.row(i) << p.x2 * p.x1, p.x2 * p.y1, p.x2, p.y2 * p.x1, p.y2 * p.y1, p.y2, p.x1, p.y1, 1.0;
  }
  return a;
}

// Gauss-Jordan elimination with complete pivoting; the two remaining columns span the null space.
bool NullSpace(Constraints a, Coefficients& first, Coefficients& second) {
  std::array<int, 9> column = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  double largest = 0.0;
  for (int step = 0; step < 7; ++step) {
    int row = step, best = step;
    const double pivot = a.bottomRightCorner(7 - step, 9 - step).cwiseAbs().maxCoeff(&row, &best);
    if (step == 0) largest = pivot;
    if (!(pivot > kLeastPivot * largest)) return false;
    a.row(step).swap(a.row(step + row));
    a.col(step).swap(a.col(step + best));
    std::swap(column[step], column[step + best]);
    a.row(step) /= a(step, step);
    for (int other = 0; other < 7; ++other) {
      if (other != step) a.row(other) -= a(other, step) * a.row(step);
    }
  }
  first.setZero();
  second.setZero();
  for (int step = 0; step < 7; ++step) {
    first(column[step]) = -a(step, 7);
    second(column[step]) = -a(step, 8);
  }
  first(column[7]) = 1.0;
  second(column[8]) = 1.0;
  first.normalize();
  second -= first.dot(second) * first;
  second.normalize();
  return true;
}

Eigen::Matrix3d AsMatrix(const Coefficients& f) {
  Eigen::Matrix3d m;
  m << f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7), f(8);
  return m;
}

// det(t A + B) = c3 t^3 + c2 t^2 + c1 t + c0, by the mixed determinants.
std::array<double, 4> DeterminantCubic(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const auto mixed = [](const Eigen::Matrix3d& x, const Eigen::Matrix3d& y) {
    return x.row(0).dot(y.row(1).cross(y.row(2))) + x.row(1).dot(y.row(2).cross(y.row(0))) +
           x.row(2).dot(y.row(0).cross(y.row(1)));
  };
  return {b.determinant(), mixed(a, b), mixed(b, a), a.determinant()};
}

double Polish(const std::array<double, 4>& c, double t) {
  for (int step = 0; step < 3; ++step) {
    const double value = ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
    const double slope = (3.0 * c[3] * t + 2.0 * c[2]) * t + c[1];
    const double next = t - value / slope;
    if (!std::isfinite(next)) break;
    t = next;
  }
  return t;
}

int QuadraticRoots(double a, double b, double c, std::array<double, 3>& roots) {
  if (a == 0.0) {
    if (b == 0.0) return 0;
    roots[0] = -c / b;
    return 1;
  }
  const double discriminant = b * b - 4.0 * a * c;
  if (!(discriminant >= 0.0)) return 0;
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  roots[0] = q / a;
  if (q == 0.0 || discriminant == 0.0) return 1;
  roots[1] = c / q;
  return 2;
}

}  // namespace

int RealCubicRoots(const std::array<double, 4>& c, std::array<double, 3>& roots) {
  constexpr double kVanishing = 1e-14;
  const double size = std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]) + std::abs(c[3]);
  int count = 0;
  if (!(std::abs(c[3]) > kVanishing * size)) {
    count = QuadraticRoots(c[2], c[1], c[0], roots);
  } else {
    // Monic, shifted by a third: t = s - a / 3, s^3 + p s + q = 0.
    const double a = c[2] / c[3], b = c[1] / c[3], d = c[0] / c[3];
    const double p = b - a * a / 3.0;
    const double q = (2.0 * a * a - 9.0 * b) * a / 27.0 + d;
    const double discriminant = q * q / 4.0 + p * p * p / 27.0;
    if (discriminant > 0.0) {
      const double root = std::sqrt(discriminant);
      const double u = std::cbrt(-q / 2.0 - std::copysign(root, q));  // without cancellation
      roots[0] = u - (u == 0.0 ? 0.0 : p / (3.0 * u)) - a / 3.0;
      count = 1;
    } else {
      const double radius = std::sqrt(std::max(-p / 3.0, 0.0));
      const double cosine = radius > 0.0 ? -q / (2.0 * radius * radius * radius) : 1.0;
      const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)) / 3.0;
      constexpr double kThirdTurn = 2.0943951023931957;
      for (int k = 0; k < 3; ++k) {
        roots[k] = 2.0 * radius * std::cos(angle - k * kThirdTurn) - a / 3.0;
      }
      count = 3;
    }
  }
  for (int i = 0; i < count; ++i) roots[i] = Polish(c, roots[i]);
  std::sort(roots.begin(), roots.begin() + count);
  return count;
}

SevenPointSolutions SolveSevenPoint(const std::array<PointPair, 7>& pairs) {
  SevenPointSolutions solutions;
  Coefficients first, second;
  if (!NullSpace(BuildConstraints(pairs), first, second)) return solutions;
  const Eigen::Matrix3d a = AsMatrix(first), b = AsMatrix(second);
  std::array<double, 3> roots;
  // det(t A + B) = 0 misses A itself, a root at infinity; det(A + t B) finds it as t = 0.
  const std::array<double, 4> cubic = DeterminantCubic(a, b);
  const bool swap = std::abs(cubic[3]) < std::abs(cubic[0]);
  const int count = RealCubicRoots(
      swap ? std::array<double, 4>{cubic[3], cubic[2], cubic[1], cubic[0]} : cubic, roots);
  for (int i = 0; i < count; ++i) {
    const Eigen::Matrix3d f =
        swap ? Eigen::Matrix3d(a + roots[i] * b) : Eigen::Matrix3d(roots[i] * a + b);
    const double norm = f.norm();
    if (std::isfinite(norm) && norm > 0.0) solutions.matrices[solutions.count++] = f / norm;
  }
  return solutions;
}

bool OrientationsAgree(const Eigen::Matrix3d& f, const std::array<PointPair, 7>& pairs) {
  // The second epipole e2 spans the left null space: e2 = the largest cross product of columns of
  // F.
  Eigen::Vector3d epipole = Eigen::Vector3d(f.col(0)).cross(Eigen::Vector3d(f.col(1)));
  for (const auto& [i, j] : {std::pair{0, 2}, std::pair{1, 2}}) {
    const Eigen::Vector3d other = Eigen::Vector3d(f.col(i)).cross(Eigen::Vector3d(f.col(j)));
    if (other.squaredNorm() > epipole.squaredNorm()) epipole = other;
  }
  int side = 0;
  for (const PointPair& p : pairs) {
    const Eigen::Vector3d line = f * Eigen::Vector3d(p.x1, p.y1, 1.0);
    const double product = line.dot(epipole.cross(Eigen::Vector3d(p.x2, p.y2, 1.0)));
    const int sign = product > 0.0 ? 1 : -1;
    if (side != 0 && sign != side) return false;
    side = sign;
  }
  return true;
}

}  // namespace egosieve::vision
