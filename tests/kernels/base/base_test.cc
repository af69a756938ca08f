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
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/exception_status.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/kept_memory.h"
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
  const absl::Status refused =
      StatusOf(std::system_error(EAGAIN, std::generic_category(), "thread"));
  EXPECT_EQ(refused.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(refused.message(), testing::HasSubstr("--threads=1"));
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

TEST(ImageGrid, ItsLastRowAndColumnLieOnTheBorder) {
  for (const int width : {1, 2, 5, 6, 7, 640}) {
    for (const int stride : {1, 2, 5, 6, 1000}) {
      const ImageGrid grid = {width, 3, stride};
      ASSERT_TRUE(grid.Validate().ok());
      EXPECT_EQ(grid.x_pixels(0), 0);
      EXPECT_EQ(grid.x_pixels(grid.columns() - 1), width - 1);
      for (int c = 1; c < grid.columns(); ++c) {
        EXPECT_GT(grid.x_pixels(c), grid.x_pixels(c - 1));
        EXPECT_LE(grid.x_pixels(c) - grid.x_pixels(c - 1), stride);
      }
      EXPECT_EQ(grid.size(), static_cast<int64_t>(grid.columns()) * grid.rows());
    }
  }
}

TEST(ImageGrid, BadSizesAreNamed) {
  EXPECT_THAT(ImageGrid({0, 5, 1}).Validate().message(), testing::HasSubstr("0 x 5"));
  EXPECT_THAT(ImageGrid({5, 5, 0}).Validate().message(), testing::HasSubstr("stride = 0"));
}

TEST(NormalizationForImage, TheLongerSideSpansMinusOneToOne) {
  const PixelNormalization wide = NormalizationForImage(641, 481);
  EXPECT_DOUBLE_EQ(0 * wide.scale + wide.u_offset, -1.0);
  EXPECT_DOUBLE_EQ(640 * wide.scale + wide.u_offset, 1.0);
  EXPECT_DOUBLE_EQ(480 * wide.scale + wide.v_offset, 0.75);
  const PixelNormalization single = NormalizationForImage(1, 1);
  EXPECT_EQ(single.u_offset, 0.0);
  EXPECT_EQ(single.v_offset, 0.0);
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

}  // namespace
}  // namespace egosieve::kernels
