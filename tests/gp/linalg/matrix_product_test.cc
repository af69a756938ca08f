#include "gp/linalg/matrix_product.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "gtest/gtest.h"
#include "tests/gp/linalg/random_matrices.h"

namespace egosieve::gp {
namespace {

constexpr double kUntouched = 12345.0;

// c - before - sign A B by sums in extended precision, in units of the bound of its error: depth + 1
// roundings, each of a sum that is at most |before| + |A| |B| (Higham, Accuracy and Stability of
// Numerical Algorithms, 2nd ed., 3.5).
double Error(double sign, const RowMatrix& a, const RowMatrix& b, const RowMatrix& before,
             const RowMatrix& c) {
  double worst = 0.0;
  for (int64_t i = 0; i < before.rows(); ++i) {
    for (int64_t j = 0; j < before.cols(); ++j) {
      long double sum = before(i, j), size = std::abs(before(i, j));
      for (int64_t k = 0; k < a.cols(); ++k) {
        sum += static_cast<long double>(sign) * a(i, k) * b(k, j);
        size += std::abs(static_cast<long double>(a(i, k)) * b(k, j));
      }
      const long double bound = (a.cols() + 1) * std::numeric_limits<double>::epsilon() * size;
      worst = std::max(worst, static_cast<double>(std::abs(c(i, j) - sum) / bound));
    }
  }
  return worst;
}

// Sizes around those of blocks in registers and of packed blocks.
TEST(MatrixProduct, IsTheSumWhateverTheSizes) {
  std::mt19937_64 generator = TestGenerator();
  for (const int64_t rows : {1, 6, 13, 97, 200}) {
    for (const int64_t columns : {1, 8, 17, 193, 210}) {
      for (const int64_t depth : {1, 255, 257, 600}) {
        const RowMatrix a = RandomPoints(rows, depth, generator);
        const RowMatrix b = RandomPoints(depth, columns, generator);
        const RowMatrix before = RandomPoints(rows, columns, generator);
        for (const double sign : {1.0, -1.0}) {
          RowMatrix wide = RowMatrix::Constant(rows, columns + 3, kUntouched);
          wide.leftCols(columns) = before;
          AddProduct(sign, AsIs(ViewOf(a)), AsIs(ViewOf(b)), depth,
                     {wide.data(), rows, columns, columns + 3});
          EXPECT_LE(Error(sign, a, b, before, wide.leftCols(columns)), 1.0)
              << rows << " x " << depth << " x " << columns;
          EXPECT_TRUE((wide.rightCols(3).array() == kUntouched).all());
        }
      }
    }
  }
}

TEST(MatrixProduct, TakesTransposedOperands) {
  std::mt19937_64 generator = TestGenerator();
  const RowMatrix a = RandomPoints(101, 300, generator), b = RandomPoints(300, 45, generator);
  const RowMatrix a_transposed = a.transpose(), b_transposed = b.transpose();
  RowMatrix plain = RowMatrix::Zero(101, 45), transposed = plain;
  AddProduct(1, AsIs(ViewOf(a)), AsIs(ViewOf(b)), 300, ViewOf(plain));
  AddProduct(1, Transposed(ViewOf(a_transposed)), Transposed(ViewOf(b_transposed)), 300,
             ViewOf(transposed));
  EXPECT_EQ(plain, transposed);
  EXPECT_LE(Error(1, a, b, RowMatrix::Zero(101, 45), plain), 1.0);
}

TEST(MatrixProduct, BitsDoNotDependOnTheRowsAndColumnsComputedTogether) {
  std::mt19937_64 generator = TestGenerator();
  const RowMatrix a = RandomPoints(130, 700, generator), b = RandomPoints(700, 230, generator);
  RowMatrix whole = RandomPoints(130, 230, generator), parts = whole;
  AddProduct(-1, AsIs(ViewOf(a)), AsIs(ViewOf(b)), 700, ViewOf(whole));
  for (int64_t i = 0; i < 130; i += 37) {
    for (int64_t j = 0; j < 230; j += 51) {
      const int64_t rows = std::min<int64_t>(37, 130 - i), columns = std::min<int64_t>(51, 230 - j);
      AddProduct(-1, {a.row(i).data(), 700, 1}, {b.data() + j, 230, 1}, 700,
                 {parts.data() + i * 230 + j, rows, columns, 230});
    }
  }
  EXPECT_EQ(whole, parts);
}

TEST(MatrixProduct, LeavesAnEmptyOneAlone) {
  RowMatrix c = RowMatrix::Constant(4, 4, kUntouched);
  AddProduct(1, {nullptr, 0, 1}, {nullptr, 4, 1}, 0, ViewOf(c));
  AddProduct(1, {nullptr, 3, 1}, {nullptr, 4, 1}, 3, {c.data(), 0, 4, 4});
  EXPECT_TRUE((c.array() == kUntouched).all());
}

}  // namespace
}  // namespace egosieve::gp
