#include "tools/masks/run_length.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;

TEST(RunLengths, GoDownTheColumnsAndBeginWithZeros) {
  const cv::Mat1b corner = (cv::Mat1b(2, 3) << 0, 1, 0,  //
                            0, 255, 7);
  EXPECT_THAT(RunLengths(corner), ElementsAre(2, 2, 1, 1));
  EXPECT_THAT(RunLengths(cv::Mat1b(2, 2, uint8_t{9})), ElementsAre(0, 4));
  EXPECT_THAT(RunLengths(cv::Mat1b(2, 2, uint8_t{0})), ElementsAre(4));
}

// By hand from (RU2), and what COCO's annotations have for these runs. 40 = 8 + 32: two groups;
// 5 - 40 = -35 = 29 - 64: 29 and then -2 in five bits, 30; 21 - 5 = 16 needs a group for its sign.
TEST(RunLengthText, IsCocos) {
  EXPECT_EQ(RunLengthText({6, 1, 40, 4, 5, 4, 5, 4, 21}), "61X13mN000`0");
  EXPECT_EQ(RunLengthText({0, 4}), "04");
  EXPECT_EQ(RunLengthText({15, 16, 31, 32}), "?`0o0`0");
}

}  // namespace
}  // namespace egosieve::tools
