#include "gp/linalg/incremental_cholesky.h"

#include <malloc.h>

#include <limits>
#include <random>
#include <tuple>
#include <vector>

#include "absl/strings/str_format.h"
#include "gp/linalg/cholesky.h"
#include "kernels/base/parallel_for.h"
#include "tests/gp/linalg/random_matrices.h"
#include "tests/testing/status.h"

// There only in programs under the undefined behaviour sanitizer.
extern "C" void __ubsan_handle_pointer_overflow() __attribute__((weak));

namespace egosieve::gp {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// Cholesky's backward error (Higham, Accuracy and Stability, theorem 10.3) is at most
// gamma_{n+1} |L| |L^T| by element, hence (n + 1) eps / 2 trace(K) in Frobenius' norm. The trace
// is at most sqrt(n) |K|_F, but for these Gram matrices, whose elements are of one size, at most
// 2 |K|_F + n noise. A removal from n rows applies at most n reflectors to each row of the factor,
// each of relative error a few eps / 2 of random sign, on top. In units of n eps |K|_F:
constexpr double kBackwardBound = 2.0;

RowMatrix Factor(const IncrementalCholesky& cholesky) { return CopyOf(cholesky.Factor()); }

void AppendRows(const RowMatrix& k, int64_t begin, int64_t end, IncrementalCholesky& cholesky) {
  const RowMatrix below = k.block(begin, 0, end - begin, begin);
  const RowMatrix corner = k.block(begin, begin, end - begin, end - begin);
  ASSERT_EQ(cholesky.Append(ViewOf(below), ViewOf(corner)), absl::OkStatus());
}

// `order`: rows of the largest matrix that the factor went through.
void ExpectFactorOf(const RowMatrix& k, const IncrementalCholesky& cholesky, int64_t order) {
  const RowMatrix l = Factor(cholesky);
  ASSERT_EQ(l.rows(), k.rows());
  for (int64_t i = 0; i < l.rows(); ++i) {
    EXPECT_GT(l(i, i), 0.0) << i;
    for (int64_t j = i + 1; j < l.rows(); ++j) ASSERT_EQ(l(i, j), 0.0) << i << " " << j;
  }
  EXPECT_LE(BackwardError(l, k, order), kBackwardBound);
}

class CholeskyLaws : public testing::TestWithParam<std::tuple<int, double>> {
 protected:
  int64_t n() const { return std::get<0>(GetParam()); }
  double noise() const { return std::get<1>(GetParam()); }
};

TEST_P(CholeskyLaws, FactorizeGivesTheFactor) {
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(n(), noise(), generator);
  IncrementalCholesky cholesky = FactorOf(k);
  ExpectFactorOf(k, cholesky, k.rows());
}

TEST_P(CholeskyLaws, AppendInBlocksIsTheFactorOfTheWhole) {
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(n(), noise(), generator);
  for (const int64_t block : {1, 7, 64, 200}) {
    IncrementalCholesky cholesky;
    for (int64_t begin = 0; begin < n(); begin += block) {
      AppendRows(k, begin, std::min(begin + block, n()), cholesky);
    }
    ExpectFactorOf(k, cholesky, k.rows());
  }
}

TEST_P(CholeskyLaws, RemoveIsTheFactorOfTheRest) {
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(n(), noise(), generator);
  for (const int64_t count : {int64_t{0}, int64_t{1}, n() / 3, n() - 1, n()}) {
    if (count < 0 || count > n()) continue;
    std::vector<std::vector<int64_t>> sets = {RandomRows(n(), count, generator)};
    sets.emplace_back(count);
    std::iota(sets[1].begin(), sets[1].end(), int64_t{0});  // the oldest
    sets.emplace_back(count);
    std::iota(sets[2].begin(), sets[2].end(), n() - count);  // the newest
    for (const auto& rows : sets) {
      IncrementalCholesky cholesky = FactorOf(k);
      ASSERT_TRUE(cholesky.Remove(rows).ok());
      ExpectFactorOf(Select(k, Complement(n(), rows)), cholesky, k.rows());
    }
  }
}

TEST_P(CholeskyLaws, AppendThenRemoveIsBefore) {
  auto generator = TestGenerator();
  const int64_t added = 33;
  const RowMatrix k = RandomGram(n() + added, noise(), generator);
  IncrementalCholesky cholesky = FactorOf(k.topLeftCorner(n(), n()));
  const RowMatrix before = Factor(cholesky);
  AppendRows(k, n(), n() + added, cholesky);
  std::vector<int64_t> rows(added);
  std::iota(rows.begin(), rows.end(), n());
  ASSERT_TRUE(cholesky.Remove(rows).ok());
  EXPECT_EQ(Factor(cholesky), before);  // the newest rows touch nothing above them
}

TEST_P(CholeskyLaws, SolvesHaveSmallResiduals) {
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(n(), noise(), generator);
  IncrementalCholesky cholesky = FactorOf(k);
  const RowMatrix b = RandomPoints(n(), 37, generator);
  RowMatrix x = b;
  SolveLower(cholesky.Factor(), ViewOf(x));
  SolveLowerTransposed(cholesky.Factor(), ViewOf(x));
  // (K + E) x = b with |E| <= (3 n + 1) eps |L| |L^T| (Higham, theorem 10.4).
  const double unit = (3.0 * n() + 1.0) * kEpsilon;
  EXPECT_LE((k * x - b).norm(), unit * k.trace() * x.norm());
  RowMatrix half = b;
  SolveLower(cholesky.Factor(), ViewOf(half));
  const RowMatrix l = Factor(cholesky);
  EXPECT_LE((l * half - b).norm(), (n() + 1.0) * kEpsilon * l.norm() * half.norm());
  RowMatrix other = b;
  SolveLowerTransposed(cholesky.Factor(), ViewOf(other));
  EXPECT_LE((l.transpose() * other - b).norm(), (n() + 1.0) * kEpsilon * l.norm() * other.norm());
}

TEST_P(CholeskyLaws, DeterminantAndInverseDiagonalAgreeWithEigen) {
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(n(), noise(), generator);
  IncrementalCholesky cholesky = FactorOf(k);
  const RowMatrix l = Factor(cholesky);
  double log_determinant = 0.0;
  for (int64_t i = 0; i < n(); ++i) log_determinant += 2.0 * std::log(l(i, i));
  EXPECT_NEAR(cholesky.LogDeterminant(), log_determinant, n() * kEpsilon * 40.0);
  const std::vector<int64_t> rows = RandomRows(n(), n() / 2, generator);
  const std::vector<double> diagonal = Value(cholesky.InverseDiagonal(rows));
  const RowMatrix inverse = l.triangularView<Eigen::Lower>().solve(RowMatrix::Identity(n(), n()));
  for (size_t i = 0; i < rows.size(); ++i) {
    // Two ways of substitution with the same factor: forward errors up to n eps cond(L), where
    // cond(L)^2 = cond(K) <= trace / noise.
    const double expected = inverse.col(rows[i]).squaredNorm();
    const double condition = std::sqrt(k.trace() / noise());
    EXPECT_NEAR(diagonal[i], expected, 2.0 * n() * kEpsilon * condition * expected);
  }
}

TEST_P(CholeskyLaws, ThreadCountDoesNotChangeABit) {
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(n() + 70, noise(), generator);
  const std::vector<int64_t> rows = RandomRows(n() + 70, n() / 2 + 5, generator);
  std::vector<RowMatrix> factors;
  for (const int threads : {1, 2, 5}) {
    kernels::SetMaximumThreads(threads);
    IncrementalCholesky cholesky = FactorOf(k.topLeftCorner(n(), n()));
    AppendRows(k, n(), n() + 70, cholesky);
    ASSERT_TRUE(cholesky.Remove(rows).ok());
    RowMatrix b = RowMatrix::Identity(cholesky.size(), cholesky.size());
    SolveLower(cholesky.Factor(), ViewOf(b));
    SolveLowerTransposed(cholesky.Factor(), ViewOf(b));
    factors.push_back(Factor(cholesky));
    factors.push_back(b);
  }
  kernels::SetMaximumThreads(0);
  for (size_t i = 2; i < factors.size(); ++i) EXPECT_EQ(factors[i], factors[i % 2]);
}

INSTANTIATE_TEST_SUITE_P(Sizes, CholeskyLaws,
                         testing::Combine(testing::Values(0, 1, 2, 7, 8, 9, 63, 64, 65, 200),
                                          testing::Values(1.0, 1e-3, 1e-8)),
                         [](const auto& info) {
                           return absl::StrFormat(
                               "n%d_noise1em%d", std::get<0>(info.param),
                               std::lround(-std::log10(std::get<1>(info.param))));
                         });

TEST(IncrementalCholesky, LargeSizesCrossEveryTile) {
  auto generator = TestGenerator();
  const int64_t n = 700;
  const RowMatrix k = RandomGram(n, 1e-3, generator);
  IncrementalCholesky cholesky = FactorOf(k.topLeftCorner(400, 400));
  AppendRows(k, 400, n, cholesky);
  ExpectFactorOf(k, cholesky, k.rows());
  const std::vector<int64_t> rows = RandomRows(n, 150, generator);
  ASSERT_TRUE(cholesky.Remove(rows).ok());
  ExpectFactorOf(Select(k, Complement(n, rows)), cholesky, k.rows());
}

// What far points and short length scales make: elements that are all but zero, not quite. Their
// squares underflow, which must not make numbers of 0 / 0.
TEST(IncrementalCholesky, RemovesRowsThatHardlyCorrelate) {
  const int64_t n = 40;
  for (const double correlation : {1e-20, 1e-60, 1e-90, 1e-154, 1e-160, 1e-250, 5e-324}) {
    RowMatrix k = RowMatrix::Constant(n, n, correlation);
    k.diagonal().setConstant(1.25);
    for (const std::vector<int64_t>& rows : {std::vector<int64_t>{0}, {0, 1, 2, 7, 20}}) {
      IncrementalCholesky cholesky = FactorOf(k);
      ASSERT_TRUE(cholesky.Remove(rows).ok());
      ASSERT_TRUE(Factor(cholesky).allFinite()) << correlation;
      ExpectFactorOf(Select(k, Complement(n, rows)), cholesky, n);
    }
  }
}

TEST(IncrementalCholesky, RefusesDuplicatesAndStaysUnchanged) {
  auto generator = TestGenerator();
  const int64_t n = 90;
  RowMatrix k = RandomGram(n, 1e-6, generator);
  IncrementalCholesky cholesky = FactorOf(k.topLeftCorner(80, 80));
  const RowMatrix before = Factor(cholesky);
  k.row(85) = k.row(3);  // a duplicate without noise of its own
  k.col(85) = k.col(3);
  k(85, 85) = k(3, 3);
  const RowMatrix below = k.block(80, 0, 10, 80);
  const RowMatrix corner = k.block(80, 80, 10, 10);
  absl::Status status = cholesky.Append(ViewOf(below), ViewOf(corner));
  EXPECT_THAT(status, IsError(absl::StatusCode::kFailedPrecondition, "row 85"));
  EXPECT_EQ(Factor(cholesky), before);
  status = Factorize(k, cholesky);
  EXPECT_THAT(status, IsError(absl::StatusCode::kFailedPrecondition, "row 85"));
  EXPECT_EQ(Factor(cholesky), before);

  RowMatrix poisoned = RandomGram(90, 1e-6, generator);
  poisoned(70, 20) = std::numeric_limits<double>::quiet_NaN();
  status = Factorize(poisoned, cholesky);
  EXPECT_THAT(status, IsError(absl::StatusCode::kFailedPrecondition, "row 70"));
  EXPECT_EQ(Factor(cholesky), before);

  // After refusals the factor still grows rightly.
  RowMatrix whole = RowMatrix::Identity(100, 100);
  whole.topLeftCorner(80, 80) = k.topLeftCorner(80, 80);
  AppendRows(whole, 80, 100, cholesky);
  ExpectFactorOf(whole, cholesky, 100);
}

TEST(IncrementalCholesky, NoMemoryIsAnError) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer ends the program where memory is refused";
#endif
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(10, 1e-3, generator);
  IncrementalCholesky cholesky = FactorOf(k);
  const auto fill = [](kernels::MatrixView<double>) { return absl::OkStatus(); };
  EXPECT_EQ(cholesky.Factorize(int64_t{1} << 28, fill).code(),
            absl::StatusCode::kResourceExhausted);
  ExpectFactorOf(k, cholesky, 10);
}

TEST(IncrementalCholesky, RefusesBadArguments) {
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(10, 1e-3, generator);
  IncrementalCholesky cholesky = FactorOf(k);
  const RowMatrix before = Factor(cholesky);
  using Rows = std::vector<int64_t>;
  for (const Rows& rows : {Rows{-1}, Rows{10}, Rows{3, 3}, Rows{4, 2}}) {
    EXPECT_THAT(cholesky.Remove(rows), IsInvalid());
    EXPECT_THAT(cholesky.InverseDiagonal(rows), IsInvalid());
  }
  const RowMatrix b = RowMatrix::Zero(9, 2);
  EXPECT_THAT(cholesky.Append(ViewOf(b), ViewOf(k)), IsInvalid());
  EXPECT_EQ(Factor(cholesky), before);
}

// Also where rows that a holder reads were dropped and others take their place.
TEST(IncrementalCholesky, AKeptFactorStaysAsItWas) {
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(40, 0.5, generator);
  IncrementalCholesky cholesky = FactorOf(k.topLeftCorner(20, 20));
  const IncrementalCholesky::Kept first = cholesky.Keep();
  const RowMatrix of_first = CopyOf(first.factor);
  AppendRows(k, 20, 30, cholesky);
  const IncrementalCholesky::Kept second = cholesky.Keep();
  const RowMatrix of_second = CopyOf(second.factor);
  cholesky.Truncate(25);
  AppendRows(k, 25, 40, cholesky);
  ExpectFactorOf(k, cholesky, 40);
  EXPECT_EQ(CopyOf(second.factor), of_second);
  const IncrementalCholesky::Kept third = cholesky.Keep();
  const RowMatrix of_third = CopyOf(third.factor);
  ASSERT_TRUE(cholesky.Remove({2, 30}).ok());
  EXPECT_EQ(CopyOf(first.factor), of_first);
  EXPECT_EQ(CopyOf(second.factor), of_second);
  EXPECT_EQ(CopyOf(third.factor), of_third);
}

// Without holders no memory moves.
TEST(IncrementalCholesky, CopiesNothingForHoldersThatAreGone) {
  auto generator = TestGenerator();
  const RowMatrix k = RandomGram(20, 0.5, generator);
  IncrementalCholesky cholesky = FactorOf(k);
  cholesky.Keep();
  const double* memory = cholesky.Factor().data;
  ASSERT_TRUE(cholesky.Remove({3}).ok());
  EXPECT_EQ(cholesky.Factor().data, memory);
}

// A factor that is updated for a drive's length must stay the factor, in constant memory.

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kCompiledForSanitizer = true;
#else
constexpr bool kCompiledForSanitizer = false;
#endif

// Sanitizers look for other faults, twenty times slower.
int64_t Updates() {
  const bool sanitized = kCompiledForSanitizer || &__ubsan_handle_pointer_overflow != nullptr;
  return sanitized ? 3000 : 100000;
}

constexpr int64_t kSize = 500;
constexpr int64_t kLargestBlock = 3;

// K over a fixed set of points: the model holds some of them, in the order in which they came.
class Endurance {
 public:
  Endurance(int64_t universe, std::mt19937_64& generator)
      : gram_(RandomGram(universe, 0.1, generator)) {}

  void AddRandom(int64_t count, std::mt19937_64& generator) {
    std::vector<int64_t> fresh;
    while (static_cast<int64_t>(fresh.size()) < count) {
      const int64_t point = static_cast<int64_t>(generator() % gram_.rows());
      if (!held_[point]) {
        held_[point] = true;
        fresh.push_back(point);
      }
    }
    RowMatrix below(count, points_.size()), corner(count, count);
    for (int64_t i = 0; i < count; ++i) {
      for (size_t j = 0; j < points_.size(); ++j) below(i, j) = gram_(fresh[i], points_[j]);
      for (int64_t j = 0; j < count; ++j) corner(i, j) = gram_(fresh[i], fresh[j]);
    }
    ASSERT_EQ(cholesky_.Append(ViewOf(below), ViewOf(corner)), absl::OkStatus());
    points_.insert(points_.end(), fresh.begin(), fresh.end());
  }

  void RemoveRandom(int64_t count, std::mt19937_64& generator) {
    const std::vector<int64_t> rows = RandomRows(cholesky_.size(), count, generator);
    ASSERT_TRUE(cholesky_.Remove(rows).ok());
    for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
      held_[points_[*row]] = false;
      points_.erase(points_.begin() + *row);
    }
  }

  int64_t size() const { return cholesky_.size(); }

  // |L L^T - K|_F / |K|_F.
  double RelativeError() const {
    const RowMatrix l = CopyOf(cholesky_.Factor());
    const RowMatrix k = Select(gram_, points_);
    return (l * l.transpose() - k).norm() / k.norm();
  }

 private:
  RowMatrix gram_;
  std::vector<char> held_ = std::vector<char>(gram_.rows(), 0);
  std::vector<int64_t> points_;
  IncrementalCholesky cholesky_;
};

TEST(IncrementalCholeskyEndurance, AHundredThousandMixedUpdates) {
  auto generator = TestGenerator();
  Endurance model(900, generator);
  model.AddRandom(kSize, generator);
  const int64_t updates = Updates();
  size_t memory_early = 0;
  for (int64_t update = 0; update < updates; ++update) {
    const int64_t count = 1 + static_cast<int64_t>(generator() % kLargestBlock);
    if (model.size() > kSize) {
      model.RemoveRandom(count, generator);
    } else {
      model.AddRandom(count, generator);
    }
    if (update == updates / 10) memory_early = mallinfo2().uordblks;
  }
  EXPECT_LE(mallinfo2().uordblks, memory_early + (1u << 16));
  EXPECT_LE(model.RelativeError(), 1e-13);
}

}  // namespace
}  // namespace egosieve::gp
