// Linear algebra in the device's memory, by what defines each result.
#include "kernels/ops/device_linear_algebra.h"

#include <CL/opencl.hpp>
#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>

#include "gtest/gtest.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels::opencl {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Tiles of 8, so that sizes lie around one, two and many of them; and those of use.
constexpr LinearAlgebraShape kSmall = {8, 2, 4};

class DeviceLinearAlgebraTest : public testing::TestWithParam<std::tuple<int, bool>> {
 protected:
  void SetUp() override {
    if (TestIsOnReference()) GTEST_SKIP() << "the reference has no device";
    n_ = std::get<0>(GetParam());
    workspace_ = Value(TestContext()->Borrow("testing"));
    algebra_ = Value(DeviceLinearAlgebra::Create(
        *TestContext(), *workspace_, std::get<1>(GetParam()) ? LinearAlgebraShape() : kSmall));
    // Eigenvalues of 0.5 and above.
    const Matrix half = Matrix::NullaryExpr(n_, n_, [&] { return Uniform(random_, -1.0, 1.0); });
    a_ = half * half.transpose() / n_ + 0.5 * Matrix::Identity(n_, n_);
  }

  DeviceMatrix Upload(const Matrix& matrix) const {
    DeviceMatrix device = NewDeviceMatrix(*TestContext(), matrix.rows(), matrix.cols());
    workspace_->queue().enqueueWriteBuffer(device.buffer, CL_TRUE, 0,
                                           matrix.size() * sizeof(double), matrix.data());
    return device;
  }
  Matrix Download(const DeviceMatrix& device) const {
    Matrix matrix(device.rows, device.columns);
    workspace_->queue().enqueueReadBuffer(device.buffer, CL_TRUE, 0, matrix.size() * sizeof(double),
                                          matrix.data());
    return matrix;
  }
  // The factor of `a`; bad_row_ is set.
  DeviceFactor Factorize(const Matrix& a) {
    const cl::Buffer bad(TestContext()->cl_context(), CL_MEM_READ_WRITE, sizeof(cl_int));
    workspace_->queue().enqueueFillBuffer(bad, cl_int{-1}, 0, sizeof(cl_int));
    DeviceMatrix device = Upload(a), floors = NewDeviceMatrix(*TestContext(), n_, 1);
    algebra_.AddNoise(device, 0.0, Upload(Matrix::Zero(n_, 1)), 1e-13, floors);
    DeviceFactor factor = algebra_.Factorize(device, floors, bad);
    workspace_->queue().enqueueReadBuffer(bad, CL_TRUE, 0, sizeof bad_row_, &bad_row_);
    return factor;
  }
  Matrix Lower(const DeviceMatrix& device) const {
    return Download(device).triangularView<Eigen::Lower>();
  }

  // Rounding errors of n terms, each of at most the matrix's norm; 20 for inverted blocks, whose
  // condition is that of a.
  double Tolerance() const {
    return 20.0 * n_ * std::numeric_limits<double>::epsilon() * a_.norm();
  }

  std::mt19937_64 random_ = TestRandom();
  int n_ = 0;
  std::unique_ptr<Workspace> workspace_;
  DeviceLinearAlgebra algebra_;
  Matrix a_;
  cl_int bad_row_ = -1;
};

TEST_P(DeviceLinearAlgebraTest, FactorTimesItselfIsTheMatrix) {
  // What lies above the diagonal is not read.
  Matrix lower = a_;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(std::nan(""));
  const Matrix l = Lower(Factorize(lower).lower);
  EXPECT_EQ(bad_row_, -1);
  EXPECT_LE((l * l.transpose() - a_).cwiseAbs().maxCoeff(), Tolerance());
  EXPECT_GT(l.diagonal().minCoeff(), 0.0);
}

TEST_P(DeviceLinearAlgebraTest, SolvesFromBothSides) {
  const DeviceFactor factor = Factorize(a_);
  const Matrix l = Lower(factor.lower);
  for (const int columns : {1, 3, 21}) {
    const Matrix b = Matrix::NullaryExpr(n_, columns, [&] { return Uniform(random_, -1.0, 1.0); });
    DeviceMatrix x = Upload(b);
    algebra_.SolveLower(factor, x);
    EXPECT_LE((l * Download(x) - b).cwiseAbs().maxCoeff(), Tolerance());
    x = Upload(b);
    algebra_.SolveLowerTransposed(factor, x);
    EXPECT_LE((l.transpose() * Download(x) - b).cwiseAbs().maxCoeff(), Tolerance());
  }
}

TEST_P(DeviceLinearAlgebraTest, InverseTimesTheMatrixIsTheIdentity) {
  const DeviceFactor factor = Factorize(a_);
  const Matrix l = Lower(factor.lower);
  const DeviceMatrix r = algebra_.InvertLower(factor);
  const Matrix inverse_of_l = Download(r);
  EXPECT_LE((l * inverse_of_l - Matrix::Identity(n_, n_)).cwiseAbs().maxCoeff(), Tolerance());
  if (n_ > 1) {
    EXPECT_EQ(Matrix(inverse_of_l.triangularView<Eigen::StrictlyUpper>()).norm(), 0.0);
  }
  DeviceMatrix inverse = NewDeviceMatrix(*TestContext(), n_, n_);
  algebra_.MultiplyInverse(r, inverse);
  const Matrix whole = Matrix(Lower(inverse).selfadjointView<Eigen::Lower>());
  EXPECT_LE((whole * a_ - Matrix::Identity(n_, n_)).cwiseAbs().maxCoeff(), 10.0 * Tolerance());
}

TEST_P(DeviceLinearAlgebraTest, NamesTheFirstRowThatIsRefused) {
  for (const int row : {0, n_ / 2, n_ - 1}) {
    Matrix a = a_;
    a(row, row) = -1.0;
    if (row < n_ - 1) a(n_ - 1, n_ - 1) = -1.0;
    Factorize(a);
    EXPECT_EQ(bad_row_, row);
    for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
      a = a_;
      a(row, row) = value;
      Factorize(a);
      EXPECT_EQ(bad_row_, row) << value;
    }
  }
}

TEST_P(DeviceLinearAlgebraTest, AddsNoiseAndWeighs) {
  const Matrix v = Matrix::NullaryExpr(n_, 1, [&] { return Uniform(random_, 0.0, 1.0); });
  DeviceMatrix a = Upload(a_), floors = NewDeviceMatrix(*TestContext(), n_, 1);
  algebra_.AddNoise(a, 0.25, Upload(v), 0.5, floors);
  Matrix expected = a_;
  for (int i = 0; i < n_; ++i) expected(i, i) = (a_(i, i) + 0.25) + v(i);
  EXPECT_EQ(Download(a), expected);
  EXPECT_EQ(Download(floors), 0.5 * expected.diagonal());
  DeviceMatrix diagonal = NewDeviceMatrix(*TestContext(), n_, 1);
  algebra_.GetDiagonal(a, diagonal);
  EXPECT_EQ(Download(diagonal), Matrix(expected.diagonal()));
  const Matrix u = Matrix::NullaryExpr(n_, 3, [&] { return Uniform(random_, -1.0, 1.0); });
  algebra_.LikelihoodWeights(Upload(u), a);
  const Matrix weights = u * u.transpose() - 3.0 * expected;
  EXPECT_LE((Lower(a) - Matrix(weights.triangularView<Eigen::Lower>())).cwiseAbs().maxCoeff(),
            Tolerance());
}

INSTANTIATE_TEST_SUITE_P(SmallTiles, DeviceLinearAlgebraTest,
                         testing::Combine(testing::Values(1, 7, 8, 9, 16, 45),
                                          testing::Values(false)));
INSTANTIATE_TEST_SUITE_P(TilesOfUse, DeviceLinearAlgebraTest,
                         testing::Combine(testing::Values(1, 64, 65, 150), testing::Values(true)));

}  // namespace
}  // namespace egosieve::kernels::opencl
