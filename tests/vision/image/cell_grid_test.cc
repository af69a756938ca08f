#include "vision/image/cell_grid.h"

#include <cmath>
#include <cstddef>

#include "gtest/gtest.h"

namespace egosieve::vision {
namespace {

TEST(CellAlong, TruncatesAndClamps) {
  EXPECT_EQ(CellAlong(std::nan(""), 4), 0);
  EXPECT_EQ(CellAlong(0.0, 4), 0);
  EXPECT_EQ(CellAlong(0.999, 4), 0);
  EXPECT_EQ(CellAlong(1.0, 4), 1);
  EXPECT_EQ(CellAlong(3.7f, 4), 3);
  EXPECT_EQ(CellAlong(-0.5, 4), 0);
  EXPECT_EQ(CellAlong(-3, 4), 0);
  EXPECT_EQ(CellAlong(4, 4), 3);
  EXPECT_EQ(CellAlong(1e18, 4), 3);  // beyond all integers
  EXPECT_EQ(CellAlong(-1e18, 4), 0);
}

TEST(CellGrid, CountsRowByRow) {
  constexpr CellGrid kGrid{.columns = 3, .rows = 2};
  EXPECT_EQ(kGrid.size(), 6u);
  size_t next = 0;
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) {
      EXPECT_EQ(kGrid.Index(row, column), next);
      EXPECT_EQ(kGrid.IndexAt(column + 0.5, row + 0.5), next);
      ++next;
    }
  }
  EXPECT_EQ(kGrid.IndexAt(9.0, -1.0), 2u);
}

TEST(SquareCells, OfPixelsHaveOneMoreWhereTheLastIsCut) {
  const SquareCells<int> whole = CellsOfPixels({64, 32}, 32);
  EXPECT_EQ(whole.columns, 2);
  EXPECT_EQ(whole.rows, 1);
  const SquareCells<int> cut = CellsOfPixels({65, 33}, 32);
  EXPECT_EQ(cut.columns, 3);
  EXPECT_EQ(cut.rows, 2);
  // Every pixel is in a cell without clamping, and every row and column has one.
  for (int x = 0; x < 65; ++x) EXPECT_EQ(cut.ColumnOf(x), x / 32) << x;
  EXPECT_EQ(cut.ColumnOf(64), 2);
  EXPECT_EQ(cut.RowOf(32), 1);
}

TEST(SquareCells, UpToAPositionContainIt) {
  const auto cells = CellsUpTo(64, 31, 32);
  EXPECT_EQ(cells.columns, 3);
  EXPECT_EQ(cells.rows, 1);
  const auto fractional = CellsUpTo(10.0f, 4.9f, 2.5f);
  EXPECT_EQ(fractional.columns, 5);
  EXPECT_EQ(fractional.rows, 2);
  EXPECT_EQ(fractional.IndexOf(10.0f, 4.9f), 9u);
}

TEST(SquareCells, APositionIsInItsCellOrTheNearest) {
  const auto cells = CellsUpTo(100, 50, 12.5);  // 9 columns, 5 rows
  EXPECT_EQ(cells.size(), 45u);
  EXPECT_EQ(cells.IndexOf(0.0f, 0.0f), 0u);
  EXPECT_EQ(cells.IndexOf(12.5f, 12.4f), 1u);
  EXPECT_EQ(cells.IndexOf(12.4f, 12.5f), 9u);
  EXPECT_EQ(cells.IndexOf(-7.0f, 30.0f), 18u);
  EXPECT_EQ(cells.IndexOf(500.0f, 500.0f), 44u);
}

// A quotient just below a whole number is not rounded up to it: if x < k side, then k side - x is
// at least the spacing of floats at x, so k - x / side is more than half the spacing below k.
TEST(SquareCells, FractionalPositionsHaveTheCellOfTheirPixel) {
  for (const int side : {3, 7, 10, 24, 31}) {
    const auto cells = CellsUpTo(4000, 4000, side);
    for (int x = 1; x <= 4000; ++x) {
      const float before = std::nextafter(static_cast<float>(x), 0.0f);
      EXPECT_EQ(cells.ColumnOf(before), (x - 1) / side) << x << " / " << side;
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
