#include "gp/linalg/tile_operations.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "gp/linalg/matrix_product.h"

namespace egosieve::gp::tile {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Map = Eigen::Map<Matrix, Eigen::Unaligned, Eigen::OuterStride<>>;
using ConstMap = Eigen::Map<const Matrix, Eigen::Unaligned, Eigen::OuterStride<>>;

constexpr int64_t kSubstitutionSize = 16;
constexpr int64_t kSubstitutionRows = 64;

Map ToEigen(View m) { return Map(m.data, m.rows, m.cols, Eigen::OuterStride<>(m.stride)); }
ConstMap ToEigen(ConstView m) {
  return ConstMap(m.data, m.rows, m.cols, Eigen::OuterStride<>(m.stride));
}

// C += kSign A B, with each operand in both libraries' terms: matrix_product.h is faster from
// kLarge on (bench/gp/linalg/matrix_product_bench.cc), Eigen below. The former allocates memory at a
// thread's first use; row_removal.cc, which may not fail, has products narrower than kLarge alone.
template <int kSign, typename A, typename B>
void Add(ProductOperand packed_a, ProductOperand packed_b, const A& a, const B& b, View c) {
  constexpr int64_t kLarge = 64;
  const int64_t depth = a.cols();
  if (c.rows >= kLarge && c.cols >= kLarge && depth >= kLarge) {
    gp::AddProduct(kSign, packed_a, packed_b, depth, c);
  } else if (!c.empty() && depth > 0) {
    if constexpr (kSign > 0) {
      ToEigen(c).noalias() += a * b;
    } else {
      ToEigen(c).noalias() -= a * b;
    }
  }
}

// The first part of a split of n: a multiple of the substitution's size.
int64_t FirstHalf(int64_t n) {
  return std::max(kSubstitutionSize, n / 2 / kSubstitutionSize * kSubstitutionSize);
}

void SubstituteForward(ConstView l, View b) {
  for (int64_t i = 0; i < l.rows; ++i) {
    double* target = b.row(i);
    for (int64_t j = 0; j < i; ++j) {
      const double factor = l(i, j);
      const double* source = b.row(j);
      for (int64_t c = 0; c < b.cols; ++c) target[c] -= factor * source[c];
    }
    const double pivot = l(i, i);
    for (int64_t c = 0; c < b.cols; ++c) target[c] /= pivot;
  }
}

void SubstituteBackward(ConstView l, View b) {
  for (int64_t i = l.rows - 1; i >= 0; --i) {
    double* target = b.row(i);
    for (int64_t j = i + 1; j < l.rows; ++j) {
      const double factor = l(j, i);
      const double* source = b.row(j);
      for (int64_t c = 0; c < b.cols; ++c) target[c] -= factor * source[c];
    }
    const double pivot = l(i, i);
    for (int64_t c = 0; c < b.cols; ++c) target[c] /= pivot;
  }
}

// X := X L^-T for a small L, by forward substitution on X^T, so that the inner loops run over
// contiguous memory.
void SubstituteRight(ConstView l, View x) {
  alignas(64) double transposed[kSubstitutionSize * kSubstitutionRows];
  for (int64_t begin = 0; begin < x.rows; begin += kSubstitutionRows) {
    const int64_t rows = std::min(kSubstitutionRows, x.rows - begin);
    const View block(transposed, l.rows, rows, kSubstitutionRows);
    for (int64_t i = 0; i < rows; ++i) {
      const double* source = x.row(begin + i);
      for (int64_t j = 0; j < l.rows; ++j) block(j, i) = source[j];
    }
    SubstituteForward(l, block);
    for (int64_t i = 0; i < rows; ++i) {
      double* target = x.row(begin + i);
      for (int64_t j = 0; j < l.rows; ++j) target[j] = block(j, i);
    }
  }
}

int64_t FactorizeSmall(View a, const double* floors) {
  for (int64_t i = 0; i < a.rows; ++i) {
    for (int64_t j = 0; j <= i; ++j) {
      double sum = a(i, j);
      for (int64_t p = 0; p < j; ++p) sum -= a(i, p) * a(j, p);
      if (j < i) {
        a(i, j) = sum / a(j, j);
      } else {
        if (!(sum > floors[i]) || std::isinf(sum)) return i;
        a(i, i) = std::sqrt(sum);
      }
    }
  }
  return -1;
}

}  // namespace

void SubtractProduct(ConstView a, ConstView b, View c) {
  Add<-1>(AsIs(a), AsIs(b), ToEigen(a), ToEigen(b), c);
}

void SubtractProductTransposed(ConstView a, ConstView b, View c) {
  Add<-1>(AsIs(a), Transposed(b), ToEigen(a), ToEigen(b).transpose(), c);
}

void SubtractTransposedProduct(ConstView a, ConstView b, View c) {
  Add<-1>(Transposed(a), AsIs(b), ToEigen(a).transpose(), ToEigen(b), c);
}

void AddProduct(ConstView a, ConstView b, View c) {
  Add<1>(AsIs(a), AsIs(b), ToEigen(a), ToEigen(b), c);
}

void AddProductTransposed(ConstView a, ConstView b, View c) {
  Add<1>(AsIs(a), Transposed(b), ToEigen(a), ToEigen(b).transpose(), c);
}

void AddTransposedProduct(ConstView a, ConstView b, View c) {
  Add<1>(Transposed(a), AsIs(b), ToEigen(a).transpose(), ToEigen(b), c);
}

void SolveLeft(ConstView l, View b) {
  if (b.empty()) return;
  if (l.rows <= kSubstitutionSize) return SubstituteForward(l, b);
  const int64_t half = FirstHalf(l.rows);
  const int64_t rest = l.rows - half;
  const View top = Block(b, 0, 0, half, b.cols);
  const View bottom = Block(b, half, 0, rest, b.cols);
  SolveLeft(Block(l, 0, 0, half, half), top);
  SubtractProduct(Block(l, half, 0, rest, half), top, bottom);
  SolveLeft(Block(l, half, half, rest, rest), bottom);
}

void SolveLeftTransposed(ConstView l, View b) {
  if (b.empty()) return;
  if (l.rows <= kSubstitutionSize) return SubstituteBackward(l, b);
  const int64_t half = FirstHalf(l.rows);
  const int64_t rest = l.rows - half;
  const View top = Block(b, 0, 0, half, b.cols);
  const View bottom = Block(b, half, 0, rest, b.cols);
  SolveLeftTransposed(Block(l, half, half, rest, rest), bottom);
  SubtractTransposedProduct(Block(l, half, 0, rest, half), bottom, top);
  SolveLeftTransposed(Block(l, 0, 0, half, half), top);
}

void SolveRightTransposed(ConstView l, View x) {
  if (x.empty()) return;
  if (l.rows <= kSubstitutionSize) return SubstituteRight(l, x);
  const int64_t half = FirstHalf(l.rows);
  const int64_t rest = l.rows - half;
  const View left = Block(x, 0, 0, x.rows, half);
  const View right = Block(x, 0, half, x.rows, rest);
  SolveRightTransposed(Block(l, 0, 0, half, half), left);
  SubtractProductTransposed(left, Block(l, half, 0, rest, half), right);
  SolveRightTransposed(Block(l, half, half, rest, rest), right);
}

int64_t Factorize(View a, const double* floors) {
  if (a.rows <= kSubstitutionSize) return FactorizeSmall(a, floors);
  const int64_t half = FirstHalf(a.rows);
  const int64_t rest = a.rows - half;
  const View corner = Block(a, 0, 0, half, half);
  if (const int64_t bad = Factorize(corner, floors); bad >= 0) return bad;
  const View below = Block(a, half, 0, rest, half);
  SolveRightTransposed(corner, below);
  for (int64_t i = 0; i < rest; i += kSubstitutionRows) {
    const int64_t rows = std::min(kSubstitutionRows, rest - i);
    SubtractProductTransposed(Block(below, i, 0, rows, half), Block(below, 0, 0, i + rows, half),
                              Block(a, half + i, half, rows, i + rows));
  }
  const int64_t bad = Factorize(Block(a, half, half, rest, rest), floors + half);
  return bad < 0 ? bad : half + bad;
}

}  // namespace egosieve::gp::tile
