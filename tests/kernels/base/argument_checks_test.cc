#include "kernels/base/argument_checks.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"
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

}  // namespace
}  // namespace egosieve::kernels
