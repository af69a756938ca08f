#include "kernels/base/image_grid.h"

#include "gmock/gmock.h"

namespace egosieve::kernels {
namespace {

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

}  // namespace
}  // namespace egosieve::kernels
