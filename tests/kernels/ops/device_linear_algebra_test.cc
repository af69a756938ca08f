// Linear algebra in the device's memory, by what defines each result.
#include "kernels/ops/device_linear_algebra.h"

#include <CL/opencl.hpp>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "kernels/ops/device_preparation.h"
#include "kernels/ops/posterior_tiling.h"
#include "kernels/runtime/opencl_context.h"
#include "kernels/runtime/tuning.h"
#include "tests/kernels/covariance/expressions.h"
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

// Points prepared on the device are those that the host prepares.

constexpr int64_t kCount = 21, kPadded = 24;

class DevicePreparationTest : public testing::TestWithParam<std::string> {
 protected:
  // As columns, of D inputs around 3.
  void ExpectTheHosts(int64_t dimension) const {
    std::mt19937_64 random = TestRandom();
    const CovarianceParameters parameters = ParametersOf(GetParam(), dimension);
    if (dimension < parameters.function.description().LeastDimension()) return;
    std::vector<double> centre(dimension);
    for (int64_t d = 0; d < dimension; ++d) centre[d] = 3.0 + 0.001 * static_cast<double>(d);
    const PointPreparation preparation(parameters, centre);
    std::vector<float> points;
    for (const double value : RandomPoints(random, kCount, dimension)) {
      points.push_back(static_cast<float>(value + 3.0));
    }
    Context& context = *TestContext();
    auto workspace = Value(context.Borrow("testing"));
    const cl::CommandQueue& queue = workspace->queue();
    const DevicePreparation device(context, parameters, preparation);
    auto kernel = Value(device.Kernel<float>(context, *workspace));
    const int64_t width = preparation.width();
    const cl::Buffer input(context.cl_context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                           points.size() * sizeof(float), points.data());
    const cl::Buffer output(context.cl_context(), CL_MEM_READ_WRITE,
                            width * kPadded * sizeof(float));
    device.Enqueue(kernel, queue, {input, 0, dimension, kCount}, {output, kPadded, 1, kPadded}, {});
    std::vector<float> actual(width * kPadded);
    queue.enqueueReadBuffer(output, CL_TRUE, 0, actual.size() * sizeof(float), actual.data());
    std::vector<double> expected(width);
    for (int64_t i = 0; i < kPadded; ++i) {
      if (i < kCount) preparation.Prepare(&points[i * dimension], expected.data(), 1);
      for (int64_t c = 0; c < width; ++c) {
        const double value = i < kCount ? expected[c] : 0.0;
        // One rounding to float32, and what the sine and contracted sums of float64 leave.
        ASSERT_NEAR(actual[c * kPadded + i], value,
                    std::ldexp(std::abs(value), -24) * (1.0 + 1e-6) + 1e-14)
            << "value " << c << " of point " << i;
      }
    }
  }
};

TEST_P(DevicePreparationTest, IsTheHosts) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference prepares on the host";
  for (const int64_t dimension : {1, 6, 32, 100}) ExpectTheHosts(dimension);
}

INSTANTIATE_TEST_SUITE_P(Columns, DevicePreparationTest, testing::Values(kOfColumns));
INSTANTIATE_TEST_SUITE_P(Functions, DevicePreparationTest, testing::ValuesIn(Expressions()),
                         [](const auto& info) {
                           std::string name = std::to_string(info.index) + "_";
                           for (const char c : info.param) {
                             if (std::isalnum(static_cast<unsigned char>(c))) name.push_back(c);
                           }
                           return name;
                         });

// Shapes for points of every width: they fit the local memory, and use it as long as it is enough.

constexpr int64_t kUsualBytes = 48 << 10;

// Bytes of the array `stage` of kernels/cl/dense_posterior_local.cl, with a factor and without.
int64_t StageBytes(const KernelTuning& tuning, int64_t width, int64_t local_bytes) {
  const int64_t group = tuning.panel * tuning.panels_per_group;
  const int64_t queries = tuning.width * (tuning.work_group / tuning.panels_per_group);
  const int64_t with_factor = std::max(
      {group * width, tuning.depth * (group + queries), tuning.panels_per_group * queries});
  return 4 * std::max(with_factor, StagedPoints(width, local_bytes) * (width + 1));
}

TEST(LocalTiles, NarrowPointsKeepTheDevicesShape) {
  for (const int64_t width : {1, 8, 33, 95}) {
    EXPECT_EQ(FitLocalMemory(DefaultGpuTuning(), width, kUsualBytes), DefaultGpuTuning());
    EXPECT_EQ(StagedPoints(width, kUsualBytes), 64);
  }
}

TEST(LocalTiles, WidePointsTakeSmallerBlocks) {
  // The last width at which 128, 64, 32, 16 and 8 rows of P + 1 values fit in 12,288 floats.
  const int64_t last[] = {95, 191, 383, 767, 1535};
  const int depth[] = {8, 8, 8, 8, 4};  // that of 8 rows by 2,048 queries takes 66 KB with 8
  int panels = DefaultGpuTuning().panels_per_group, points = 64;
  for (int i = 1; i < 5; ++i) {
    panels /= 2;
    if (i > 1) points /= 2;
    KernelTuning expected = DefaultGpuTuning();
    expected.panels_per_group = panels;
    expected.depth = depth[i];
    for (const int64_t width : {last[i - 1] + 1, last[i]}) {
      EXPECT_EQ(FitLocalMemory(DefaultGpuTuning(), width, kUsualBytes), expected) << width;
      EXPECT_EQ(StagedPoints(width, kUsualBytes), points) << width;
    }
  }
}

TEST(LocalTiles, ThoseThatNeverFitTakeWorkItemsSideBySide) {
  KernelTuning scalar = DefaultTuning(1);
  scalar.work_group = 64;
  EXPECT_EQ(FitLocalMemory(DefaultGpuTuning(), 1536, kUsualBytes), scalar);
  EXPECT_EQ(FitLocalMemory(DefaultGpuTuning(), 1, 1024), scalar);
  EXPECT_TRUE(scalar.Validate().ok());
}

TEST(LocalTiles, OtherShapesStayAsTheyAre) {
  for (const int lanes : {1, 4, 8, 16}) {
    EXPECT_EQ(FitLocalMemory(DefaultTuning(lanes), 5000, 1024), DefaultTuning(lanes));
  }
}

// Also of a table with numbers that are no powers of two.
TEST(LocalTiles, EveryShapeIsValidAndFits) {
  KernelTuning odd = DefaultGpuTuning();
  odd.panel = 3;
  odd.panels_per_group = 24;
  odd.depth = 36;
  odd.work_group = 96;
  ASSERT_TRUE(odd.Validate().ok());
  for (const KernelTuning& tuning : {DefaultGpuTuning(), odd}) {
    for (const int64_t bytes : {int64_t{16} << 10, int64_t{32} << 10, kUsualBytes}) {
      for (int64_t width = 1; width < 3000; width += 7) {
        const KernelTuning fitting = FitLocalMemory(tuning, width, bytes);
        ASSERT_TRUE(fitting.Validate().ok()) << width << ": " << fitting.Validate();
        if (!fitting.local_tiles) continue;
        ASSERT_LE(StageBytes(fitting, width, bytes), bytes) << width;
      }
    }
  }
}

}  // namespace
}  // namespace egosieve::kernels::opencl
