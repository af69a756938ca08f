#include <sys/resource.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/exception_status.h"
#include "kernels/base/kept_memory.h"
#include "kernels/base/prepared_points.h"
#include "kernels/covariance/arcsine.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

TEST(CheckShape, NamesTheArgumentAndBothShapes) {
  const double data[6] = {};
  EXPECT_TRUE(CheckShape("x", ConstMatrixView<double>(data, 2, 3), 2, 3).ok());
  EXPECT_EQ(CheckShape("x", ConstMatrixView<double>(data, 2, 3), 2, 4).message(),
            "x is 2 x 3; it must be 2 x 4");
  EXPECT_EQ(CheckShape("x", ConstMatrixView<double>(data, 2, 3, 2), 2, 3).message(),
            "x has stride 2; it must be at least its 3 columns");
  EXPECT_EQ(CheckShape("x", ConstMatrixView<double>(nullptr, 2, 3), 2, 3).message(),
            "x is 2 x 3 but its data is null");
  EXPECT_TRUE(CheckShape("x", ConstMatrixView<double>(nullptr, 0, 3), 0, 3).ok());
}

TEST(CheckFinite, NamesTheFirstBadElementAndReadsNoPadding) {
  std::vector<double> data(5 * 4, 1e300);
  for (int i = 0; i < 5; ++i) data[i * 4 + 3] = NAN;  // beyond the columns
  const ConstMatrixView<double> view(data.data(), 5, 3, 4);
  EXPECT_TRUE(CheckFinite("x", view).ok());
  data[4 * 4 + 0] = NAN;
  data[2 * 4 + 1] = -INFINITY;
  EXPECT_EQ(CheckFinite("x", view).message(), "x(2, 1) = -inf; it must be finite");
  data[2 * 4 + 1] = 0.0;
  EXPECT_THAT(CheckFinite("x", view), IsInvalid());
}

template <typename Exception>
absl::Status StatusOf(const Exception& exception) {
  return CatchExceptions([&]() -> absl::Status { throw exception; });
}

TEST(ExceptionStatus, TellsWhatTheMachineLacks) {
  EXPECT_EQ(StatusOf(std::bad_alloc()).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(StatusOf(std::length_error("vector")).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(StatusOf(std::runtime_error("(-4:Insufficient memory) Failed to allocate")).code(),
            absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(StatusOf(std::system_error(EAGAIN, std::generic_category(), "thread")),
              IsError(absl::StatusCode::kUnavailable, "--threads=1"));
  EXPECT_EQ(StatusOf(std::runtime_error("pthread_create has failed")).code(),
            absl::StatusCode::kUnavailable);
}

TEST(ExceptionStatus, AnythingElseIsInternal) {
  EXPECT_EQ(StatusOf(std::runtime_error("odd")).code(), absl::StatusCode::kInternal);
  EXPECT_EQ(StatusOf(7).code(), absl::StatusCode::kInternal);
}

TEST(ExceptionStatus, WithoutAnExceptionTheBodysResultComesBack) {
  EXPECT_TRUE(CatchExceptions([] { return absl::OkStatus(); }).ok());
  EXPECT_EQ(*CatchExceptions([]() -> absl::StatusOr<int> { return 3; }), 3);
}

constexpr int kBlocks = 6;
constexpr size_t kBlockBytes = 8 << 20, kPageBytes = 4096;

int64_t PageFaults() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

void UseAndFree() {
  void* blocks[kBlocks];
  for (void*& block : blocks) {
    block = std::malloc(kBlockBytes);
    ASSERT_NE(block, nullptr);
    std::memset(block, 1, kBlockBytes);
  }
  for (void* block : blocks) std::free(block);
}

TEST(KeptMemory, FreedBlocksServeAgainWithoutPageFaults) {
#if !defined(__GLIBC__) || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "another allocator";
#endif
  KeepFreedMemory();
  UseAndFree();
  const int64_t before = PageFaults();
  for (int round = 0; round < 3; ++round) UseAndFree();
  EXPECT_LT(PageFaults() - before, static_cast<int64_t>(kBlockBytes / kPageBytes));
}

TEST(PointPreparation, AVectorAndItsRestHaveUnitLength) {
  std::mt19937_64 random = TestRandom();
  for (const double weight : {0.05, 1.0, 30.0, 1000.0}) {
    const CovarianceParameters parameters =
        ArcsineParameters({weight, 2 * weight, 0.5 * weight, weight});
    const std::vector<double> x = RandomPoints(random, 1, 3);
    double prepared[5];
    PointPreparation(parameters).Prepare(x.data(), prepared, 1);
    // (1): 4 |a^ / 2|^2 + 4 (e / 4) = 1, a handful of roundings.
    double sum = prepared[4];
    for (int c = 0; c < 4; ++c) sum += prepared[c] * prepared[c];
    EXPECT_NEAR(4 * sum, 1.0, 16 * std::ldexp(1.0, -53));
    EXPECT_NEAR(prepared[1] / prepared[0], 2 * x[0], 1e-14);
  }
}

TEST(PointPreparation, DifferencesAndDotProductGiveTheSameH) {
  std::mt19937_64 random = TestRandom();
  const CovarianceParameters parameters = ArcsineParameters({1.0, 2.0, 3.0});
  for (int repeat = 0; repeat < 100; ++repeat) {
    const std::vector<double> x = RandomPoints(random, 2, 2);
    double a[4], b[4];
    PointPreparation(parameters).Prepare(&x[0], a, 1);
    PointPreparation(parameters).Prepare(&x[2], b, 1);
    double z = 0.0;
    for (int c = 0; c < 3; ++c) z += 4 * a[c] * b[c];
    const double sign = z < 0 ? -1.0 : 1.0;
    double h = a[3] + b[3];
    for (int c = 0; c < 3; ++c) h += (a[c] - sign * b[c]) * (a[c] - sign * b[c]);
    EXPECT_NEAR(h, (1 - std::abs(z)) / 2, 1e-15);  // (2)
    EXPECT_NEAR(sign * (M_PI / 2 - 2 * std::asin(std::sqrt(h))), std::asin(z),
                1e-14 / std::sqrt(h));  // (3)
  }
}

TEST(PointPreparation, WritesWithTheGivenStepInEveryType) {
  const CovarianceParameters parameters = SquaredExponentialParameters({0.5, 2.0});
  const float x[] = {1.0f, 3.0f};
  std::vector<float> out(9, -1.0f);
  PointPreparation(parameters).Prepare(x, out.data(), 4);
  EXPECT_EQ(out, (std::vector<float>{2.0f, -1, -1, -1, 1.5f, -1, -1, -1, -1}));
}

TEST(PointPreparation, HugeWeightsKeepEPositiveInFloat) {
  const double x = 1.0;
  float out[3];
  PointPreparation(ArcsineParameters({1e30, 1e30})).Prepare(&x, out, 1);
  EXPECT_GT(out[2], 0.0f);
  EXPECT_NEAR(out[0], std::sqrt(0.125), 1e-7);
}

TEST(CentreOf, IsTheMiddleOfARangeThatLeavesZeroOut) {
  const double x[] = {10.0, -1.0, -7.0, 14.0, 3.0, -5.0, 11.0, 0.0, -6.0};
  EXPECT_EQ(CentreOf({x, 3, 3}), (std::vector<double>{12.0, 0.0, -6.0}));
  EXPECT_EQ(CentreOf({x, 0, 3}), (std::vector<double>{0.0, 0.0, 0.0}));
}

TEST(DifferenceThreshold, IsWhereTheBoundOfTheDotProductMeetsOneMillionth) {
  const double u = std::ldexp(1.0, -24);
  double last = 0.0;
  for (int components = 2; components <= 33; ++components) {
    const double h = DifferenceThreshold(components);
    EXPECT_GE(h, last);
    last = h;
    if (h == 1.0) continue;
    const double roundings = (components + 1) / 2 + 3;
    EXPECT_NEAR(roundings * u / (2 * std::sqrt(h * (1 - h))) + 1.5e-7, 1e-6, 1e-12);
    EXPECT_LE(h, 0.5);
  }
  EXPECT_EQ(last, 1.0);  // 33 components need differences throughout
}

}  // namespace
}  // namespace egosieve::kernels
