#include "gp/linalg/conjugate_gradients.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "gp/linalg/not_positive_definite.h"
#include "tests/gp/linalg/random_matrices.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

auto ProductWith(const RowMatrix& a) {
  return [&a](ConstMatrixView<double> v, MatrixView<double> out) {
    Eigen::Map<RowMatrix>(out.data, out.rows, out.cols) = CopyOf(v) * a;
    return absl::OkStatus();
  };
}

absl::Status Copy(ConstMatrixView<double> v, MatrixView<double> out) {
  std::copy_n(v.data, v.rows * v.cols, out.data);
  return absl::OkStatus();
}

TEST(ConjugateGradients, SolveEachColumn) {
  auto generator = TestGenerator();
  const RowMatrix a = RandomGram(300, 0.1, generator);
  RowMatrix b = RandomPoints(4, 300, generator), x = RowMatrix::Zero(4, 300);
  b.row(1) *= 1e6;
  b.row(2).setZero();
  x.row(2).setOnes();
  const ConjugateGradientOptions options;
  const auto report =
      Value(SolveByConjugateGradients(ProductWith(a), Copy, options, ViewOf(b), ViewOf(x)));
  EXPECT_TRUE(x.row(2).isZero(0.0));
  double largest = 0.0;
  for (const int c : {0, 1, 3}) {
    const double residual = (b.row(c) - x.row(c) * a).norm() / b.row(c).norm();
    EXPECT_LE(residual, options.tolerance);
    largest = std::max(largest, residual);
    // |error| <= |r| / lambda; lambda >= 0.1.
    const RowMatrix exact = a.llt().solve(b.row(c).transpose());
    EXPECT_LE((x.row(c) - exact.transpose()).norm(), 10.0 * residual * b.row(c).norm() * 1.01);
  }
  EXPECT_NEAR(report.residual, largest, 1e-12);
  EXPECT_GT(report.iterations, 10);
}

TEST(ConjugateGradients, NeedNoIterationWhereTheyStartFromTheSolution) {
  auto generator = TestGenerator();
  const RowMatrix a = RandomGram(100, 0.1, generator), b = RandomPoints(2, 100, generator);
  RowMatrix x = a.llt().solve(b.transpose()).transpose();
  const RowMatrix before = x;
  const auto report =
      Value(SolveByConjugateGradients(ProductWith(a), Copy, {}, ViewOf(b), ViewOf(x)));
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(x, before);
}

TEST(ConjugateGradients, NeedFewIterationsWithTheInverse) {
  auto generator = TestGenerator();
  const RowMatrix a = RandomGram(200, 1e-4, generator), b = RandomPoints(1, 200, generator);
  const RowMatrix inverse = a.llt().solve(RowMatrix::Identity(200, 200));
  RowMatrix x = RowMatrix::Zero(1, 200);
  const auto report = Value(
      SolveByConjugateGradients(ProductWith(a), ProductWith(inverse), {}, ViewOf(b), ViewOf(x)));
  EXPECT_LE(report.iterations, 3);
}

// Nothing is called a solution that is none.
TEST(ConjugateGradients, TellWhereTheToleranceIsNotReached) {
  auto generator = TestGenerator();
  const RowMatrix a = RandomGram(300, 1e-15, generator), b = RandomPoints(1, 300, generator);
  const auto status_of = [&](const RowMatrix& matrix, ConjugateGradientOptions options) {
    RowMatrix x = RowMatrix::Zero(1, 300);
    return SolveByConjugateGradients(ProductWith(matrix), Copy, options, ViewOf(b), ViewOf(x))
        .status();
  };
  const absl::Status singular = status_of(a, {});
  EXPECT_TRUE(IsNotPositiveDefinite(singular)) << singular;
  EXPECT_NE(singular.message().find("relative residual of"), std::string::npos) << singular;
  const RowMatrix good = RandomGram(300, 0.1, generator);
  EXPECT_TRUE(status_of(good, {1e-8, 500}).ok());
  EXPECT_TRUE(IsNotPositiveDefinite(status_of(good, {1e-8, 3})));
  EXPECT_TRUE(IsNotPositiveDefinite(status_of(-good, {})));
  EXPECT_TRUE(
      IsNotPositiveDefinite(status_of(good * std::numeric_limits<double>::quiet_NaN(), {})));
  for (const ConjugateGradientOptions& bad :
       {ConjugateGradientOptions{0.0, 9}, {1.0, 9}, {std::nan(""), 9}, {0.1, 0}}) {
    EXPECT_EQ(status_of(good, bad).code(), absl::StatusCode::kInvalidArgument);
  }
}

TEST(ConjugateGradients, EndFromAStartThatIsNoNumber) {
  auto generator = TestGenerator();
  const RowMatrix a = RandomGram(30, 0.1, generator), b = RandomPoints(1, 30, generator);
  for (const double value : {std::nan(""), 1e300}) {
    RowMatrix x = RowMatrix::Constant(1, 30, value);
    EXPECT_FALSE(SolveByConjugateGradients(ProductWith(a), Copy, {}, ViewOf(b), ViewOf(x)).ok());
  }
  // Nor does a preconditioner that is none keep it going.
  RowMatrix x = RowMatrix::Zero(1, 30);
  const RowMatrix negative = -RowMatrix::Identity(30, 30);
  EXPECT_FALSE(
      SolveByConjugateGradients(ProductWith(a), ProductWith(negative), {}, ViewOf(b), ViewOf(x))
          .ok());
}

TEST(ConjugateGradients, ReturnTheErrorsOfProducts) {
  const RowMatrix b = RowMatrix::Ones(1, 3);
  RowMatrix x = b;
  const auto fails = [](ConstMatrixView<double>, MatrixView<double>) {
    return absl::UnavailableError("lost");
  };
  EXPECT_EQ(SolveByConjugateGradients(fails, Copy, {}, ViewOf(b), ViewOf(x)).status().message(),
            "lost");
  x.setZero();
  EXPECT_EQ(SolveByConjugateGradients(Copy, fails, {}, ViewOf(b), ViewOf(x)).status().message(),
            "lost");
}

}  // namespace
}  // namespace egosieve::gp
