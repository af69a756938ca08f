#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "gp/linalg/matrix_product.h"
#include "gp/linalg/normal_samples.h"
#include "kernels/base/parallel_for.h"
#include "tests/gp/linalg/random_matrices.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

constexpr double kUntouched = 12345.0;

// A B by sums in extended precision.
class Oracle {
 public:
  Oracle(const RowMatrix& a, const RowMatrix& b) : depth_(a.cols()) {
    for (int64_t i = 0; i < a.rows(); ++i) {
      for (int64_t j = 0; j < b.cols(); ++j) {
        long double sum = 0.0, size = 0.0;
        for (int64_t k = 0; k < depth_; ++k) {
          const long double term = static_cast<long double>(a(i, k)) * b(k, j);
          sum += term;
          size += std::abs(term);
        }
        sums_.push_back({sum, size});
      }
    }
  }

  // c - before - sign A B in units of the bound of its error: depth + 1 roundings, each of a sum that
  // is at most |before| + |A| |B| (Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed.,
  // 3.5).
  double Error(double sign, const RowMatrix& before, const RowMatrix& c) const {
    double worst = 0.0;
    for (int64_t i = 0; i < before.rows(); ++i) {
      for (int64_t j = 0; j < before.cols(); ++j) {
        const auto [sum, size] = sums_[i * before.cols() + j];
        const long double bound =
            (depth_ + 1) * std::numeric_limits<double>::epsilon() * (std::abs(before(i, j)) + size);
        const long double error = std::abs(c(i, j) - before(i, j) - sign * sum);
        worst = std::max(worst, static_cast<double>(error / bound));
      }
    }
    return worst;
  }

 private:
  int64_t depth_;
  std::vector<std::pair<long double, long double>> sums_;
};

// Sizes around those of blocks in registers and of packed blocks.
TEST(MatrixProduct, IsTheSumWhateverTheSizes) {
  std::mt19937_64 generator = TestGenerator();
  for (const int64_t rows : {1, 6, 13, 97, 200}) {
    for (const int64_t columns : {1, 8, 17, 193, 210}) {
      for (const int64_t depth : {1, 255, 257, 600}) {
        const RowMatrix a = RandomPoints(rows, depth, generator);
        const RowMatrix b = RandomPoints(depth, columns, generator);
        const RowMatrix before = RandomPoints(rows, columns, generator);
        const Oracle oracle(a, b);
        for (const double sign : {1.0, -1.0}) {
          for (const ProductFunction product : ProductsOfThisProcessor()) {
            RowMatrix wide = RowMatrix::Constant(rows, columns + 3, kUntouched);
            wide.leftCols(columns) = before;
            product(sign, AsIs(ViewOf(a)), AsIs(ViewOf(b)), depth,
                    {wide.data(), rows, columns, columns + 3});
            EXPECT_LE(oracle.Error(sign, before, wide.leftCols(columns)), 1.0)
                << rows << " x " << depth << " x " << columns;
            EXPECT_TRUE((wide.rightCols(3).array() == kUntouched).all());
          }
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
  EXPECT_LE(Oracle(a, b).Error(1, RowMatrix::Zero(101, 45), plain), 1.0);
}

TEST(MatrixProduct, BitsDoNotDependOnTheRowsAndColumnsComputedTogether) {
  std::mt19937_64 generator = TestGenerator();
  const RowMatrix a = RandomPoints(130, 700, generator), b = RandomPoints(700, 230, generator);
  const RowMatrix before = RandomPoints(130, 230, generator);
  for (const ProductFunction product : ProductsOfThisProcessor()) {
    RowMatrix whole = before, parts = before;
    product(-1, AsIs(ViewOf(a)), AsIs(ViewOf(b)), 700, ViewOf(whole));
    for (int64_t i = 0; i < 130; i += 37) {
      for (int64_t j = 0; j < 230; j += 51) {
        const int64_t rows = std::min<int64_t>(37, 130 - i);
        const int64_t columns = std::min<int64_t>(51, 230 - j);
        product(-1, {a.row(i).data(), 700, 1}, {b.data() + j, 230, 1}, 700,
                {parts.data() + i * 230 + j, rows, columns, 230});
      }
    }
    EXPECT_EQ(whole, parts);
  }
}

TEST(MatrixProduct, LeavesAnEmptyOneAlone) {
  RowMatrix c = RowMatrix::Constant(4, 4, kUntouched);
  AddProduct(1, {nullptr, 0, 1}, {nullptr, 4, 1}, 0, ViewOf(c));
  AddProduct(1, {nullptr, 3, 1}, {nullptr, 4, 1}, 3, {c.data(), 0, 4, 4});
  EXPECT_TRUE((c.array() == kUntouched).all());
}

constexpr int64_t kPlaces = 5;

// Variances 1 to 5, and neighbours correlated by a half.
RowMatrix SomeCovariance() {
  RowMatrix sigma = RowMatrix::Zero(kPlaces, kPlaces);
  for (int64_t i = 0; i < kPlaces; ++i) {
    sigma(i, i) = i + 1.0;
    if (i > 0) sigma(i, i - 1) = sigma(i - 1, i) = 0.5 * std::sqrt(i * (i + 1.0));
  }
  return sigma;
}

NormalSamples Draw(const RowMatrix& mean, const RowMatrix& sigma, int64_t count, uint64_t seed) {
  std::vector<double> prior(sigma.rows());
  for (int64_t i = 0; i < sigma.rows(); ++i) prior[i] = std::max(sigma(i, i), 1e-3);
  return Value(SampleNormal(ViewOf(mean), ViewOf(sigma), prior, count, seed));
}

TEST(SampleNormal, HasTheMomentsOfTheDistribution) {
  constexpr int64_t kCount = 20000;
  RowMatrix mean(kPlaces, 2);
  for (int64_t i = 0; i < kPlaces; ++i) mean.row(i) << 10.0 * i, -3.0;
  const RowMatrix sigma = SomeCovariance();
  const NormalSamples samples = Draw(mean, sigma, kCount, 7);
  EXPECT_EQ(samples.jitter, 0.0);
  ASSERT_EQ(samples.values.cols(), 2 * kCount);
  const RowMatrix values = CopyOf(samples.values.view());
  for (int64_t c = 0; c < 2; ++c) {
    const RowMatrix y = values.block(0, c * kCount, kPlaces, kCount).colwise() - mean.col(c);
    for (int64_t i = 0; i < kPlaces; ++i) {
      // Six deviations of the estimates: sqrt(variance / S), sqrt((s_ii s_jj + s_ij^2) / S).
      EXPECT_NEAR(y.row(i).mean(), 0.0, 6.0 * std::sqrt(sigma(i, i) / kCount));
      for (int64_t j = 0; j <= i; ++j) {
        const double deviation =
            std::sqrt((sigma(i, i) * sigma(j, j) + sigma(i, j) * sigma(i, j)) / kCount);
        EXPECT_NEAR(y.row(i).dot(y.row(j)) / kCount, sigma(i, j), 6.0 * deviation);
      }
    }
    // The fourth moment of a normal value is 3; its estimate's deviation sqrt(96 / S).
    const double kurtosis = (y.row(0).array() / std::sqrt(sigma(0, 0))).pow(4).mean();
    EXPECT_NEAR(kurtosis, 3.0, 6.0 * std::sqrt(96.0 / kCount));
  }
  const RowMatrix first = values.leftCols(kCount).colwise() - mean.col(0);
  const RowMatrix second = values.rightCols(kCount).colwise() - mean.col(1);
  EXPECT_NEAR(first.row(2).dot(second.row(2)) / kCount, 0.0, 6.0 * 3.0 / std::sqrt(kCount));
}

TEST(SampleNormal, FollowsFromTheSeedAlone) {
  auto generator = TestGenerator();
  const RowMatrix sigma = RandomGram(200, 0.01, generator), mean = RowMatrix::Ones(200, 1);
  const RowMatrix whole = CopyOf(Draw(mean, sigma, 9, 3).values.view());
  const RowMatrix fewer = CopyOf(Draw(mean, sigma, 4, 3).values.view());
  EXPECT_EQ(whole.leftCols(4), fewer);
  EXPECT_NE(CopyOf(Draw(mean, sigma, 4, 4).values.view()), fewer);
  const RowMatrix many =
      CopyOf(Draw(mean.topRows(3), sigma.topLeftCorner(3, 3), 300, 3).values.view());
  for (const int64_t count : {1, 2, 3, 7, 129}) {
    EXPECT_EQ(CopyOf(Draw(mean.topRows(3), sigma.topLeftCorner(3, 3), count, 3).values.view()),
              many.leftCols(count));
  }
  kernels::SetMaximumThreads(1);
  EXPECT_EQ(CopyOf(Draw(mean, sigma, 9, 3).values.view()), whole);
  kernels::SetMaximumThreads(0);
}

TEST(SampleNormal, IncreasesTheJitterWhereThereIsNoFactor) {
  RowMatrix sigma = RowMatrix::Ones(3, 3);  // one value, three times
  const NormalSamples samples = Draw(RowMatrix::Zero(3, 1), sigma, 50, 1);
  EXPECT_EQ(samples.jitter, 1e-10);
  for (int64_t s = 0; s < 50; ++s) {
    // Two values differ by sqrt(2 jitter) z.
    EXPECT_NEAR(samples.values.row(0)[s], samples.values.row(2)[s], 6.0 * std::sqrt(2e-10));
  }
  sigma(2, 2) = -1.0;
  EXPECT_EQ(
      SampleNormal(ViewOf(RowMatrix(RowMatrix::Zero(3, 1))), ViewOf(sigma), {1.0, 1.0, 1.0}, 1, 1)
          .status()
          .code(),
      absl::StatusCode::kFailedPrecondition);
}

TEST(SampleNormal, NothingOfNothing) {
  const RowMatrix mean = RowMatrix::Zero(3, 1), sigma = RowMatrix::Identity(3, 3);
  EXPECT_EQ(Draw(mean, sigma, 0, 1).values.cols(), 0);
  EXPECT_EQ(Draw(RowMatrix(0, 1), RowMatrix(0, 0), 2, 1).values.rows(), 0);
}

}  // namespace
}  // namespace egosieve::gp
