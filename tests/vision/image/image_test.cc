#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include "gmock/gmock.h"
#include "vision/image/bilinear.h"
#include "vision/image/cell_grid.h"
#include "vision/image/inside.h"
#include "vision/image/node_grid.h"

namespace egosieve::vision {
namespace {

using ::testing::_;
using ::testing::FieldsAre;

// 10 20 40
//  0 30 80
cv::Mat1b Picture() { return (cv::Mat1b(2, 3) << 10, 20, 40, 0, 30, 80); }

TEST(AroundClamped, IsTheWholePositionBeforeAndTheNext) {
  EXPECT_THAT(AroundClamped(3.25, 6), FieldsAre(3, 4, 0.25));
  EXPECT_THAT(AroundClamped(3.0, 6), FieldsAre(3, _, 0.0));
}

TEST(AroundClamped, TheLastPositionIsInAPairOrAlone) {
  for (const float at : {5.0f, 5.5f, 1e9f}) {
    EXPECT_THAT(AroundClamped(at, 6), FieldsAre(4, 5, 1.0f)) << at;
    EXPECT_THAT(AroundClamped<AtLast::kAlone>(at, 6), FieldsAre(5, 5, 0.0f)) << at;
  }
  EXPECT_THAT(AroundClamped<AtLast::kAlone>(4.5f, 6), FieldsAre(4, 5, _));
}

TEST(AroundClamped, OutsideAndOfOneValueItIsTheNearest) {
  for (const float at : {-0.5f, -1e9f}) {
    EXPECT_THAT(AroundClamped(at, 6), FieldsAre(0, _, 0.0f)) << at;
  }
  for (const float at : {-2.0f, 0.0f, 0.7f}) {
    EXPECT_THAT(AroundClamped(at, 1), FieldsAre(0, 0, 0.0f)) << at;
  }
}

TEST(Bilinear, BothOrdersAreLinearInEachCoordinate) {
  const cv::Mat1b picture = Picture();
  const auto value = [&](int row, int column) { return static_cast<double>(picture(row, column)); };
  // Row 0 at x = 1.5: 30. Row 1: 55. A quarter of the way down: 36.25. All steps are exact.
  const Around<double> x = AroundClamped(1.5, 3), y = AroundClamped(0.25, 2);
  EXPECT_EQ(BilinearByWeights(x, y, value), 36.25);
  EXPECT_EQ(BilinearByDifferences(x, y, value), 36.25);
}

TEST(Bilinear, WeightsAreExactAtWholePositionsAndDifferencesOnEqualValues) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> level(-1000.0f, 1000.0f), share(0.0f, 1.0f);
  for (int i = 0; i < 1000; ++i) {
    const float levels[2][2] = {{level(engine), level(engine)}, {level(engine), level(engine)}};
    for (const int right : {0, 1}) {
      for (const int below : {0, 1}) {
        const Around<float> x{0, 1, static_cast<float>(right)};
        const Around<float> y{0, 1, static_cast<float>(below)};
        EXPECT_EQ(BilinearByWeights(x, y, [&](int row, int column) { return levels[row][column]; }),
                  levels[below][right]);
      }
    }
    const Around<float> x{0, 1, share(engine)}, y{0, 1, share(engine)};
    EXPECT_EQ(BilinearByDifferences(x, y, [&](int, int) { return levels[0][0]; }), levels[0][0]);
  }
}

TEST(Bilinear, TheOrdersDifferByRoundingAlone) {
  // Values up to M, u = 2^-24. Each of the six operations that follow one another in (BI1) rounds
  // by at most M u. In a row of (BI2) the difference and the product round by at most 2 M u each,
  // the sum by M u; the step between the rows adds as much. 16 M u in all, to first order in u.
  const double bound = 17 * 100 * 0x1p-24;
  std::mt19937 engine(5);
  std::uniform_real_distribution<float> level(-100.0f, 100.0f), share(0.0f, 1.0f);
  for (int i = 0; i < 1000; ++i) {
    const float levels[2][2] = {{level(engine), level(engine)}, {level(engine), level(engine)}};
    const auto value = [&](int row, int column) { return levels[row][column]; };
    const Around<float> x{0, 1, share(engine)}, y{0, 1, share(engine)};
    EXPECT_NEAR(BilinearByWeights(x, y, value), BilinearByDifferences(x, y, value), bound);
  }
}

TEST(SampleClamped, InterpolatesVectorsAndRepeatsTheBorder) {
  cv::Mat2f field(2, 2);
  field(0, 0) = {0.0f, 1.0f};
  field(0, 1) = {4.0f, 1.0f};
  field(1, 0) = {0.0f, 9.0f};
  field(1, 1) = {4.0f, 9.0f};
  EXPECT_EQ(SampleClamped<cv::Point2f>(field, 0.25f, 0.5f), cv::Point2f(1.0f, 5.0f));
  EXPECT_EQ(SampleClamped<cv::Point2f>(field, -3.0f, 0.5f), cv::Point2f(0.0f, 5.0f));
  EXPECT_EQ(SampleClamped<cv::Point2f>(field, 99.0f, 99.0f), cv::Point2f(4.0f, 9.0f));
}

TEST(SampleOrNan, InterpolatesGreyLevels) {
  const cv::Mat1b picture = Picture();
  EXPECT_EQ(SampleOrNan(picture, 0.0, 0.0), 10.0f);
  EXPECT_EQ(SampleOrNan(picture, 1.5, 0.25), 36.25f);
  EXPECT_EQ(SampleOrNan(picture, 1.0, 0.5), 25.0f);
  EXPECT_EQ(SampleOrNan(picture, 0.5, 0.5), 15.0f);  // differences of both signs
}

TEST(SampleOrNan, IsNanOutsideAndInTheLastRowAndColumn) {
  const cv::Mat1b picture = Picture();
  EXPECT_TRUE(std::isnan(SampleOrNan(picture, -1e-9, 0.0)));
  EXPECT_TRUE(std::isnan(SampleOrNan(picture, 0.0, -1e-9)));
  EXPECT_FALSE(std::isnan(SampleOrNan(picture, 2.0 - 1e-9, 1.0 - 1e-9)));
  EXPECT_TRUE(std::isnan(SampleOrNan(picture, 2.0, 0.0)));
  EXPECT_TRUE(std::isnan(SampleOrNan(picture, 0.0, 1.0)));
  EXPECT_TRUE(std::isnan(SampleOrNan(picture, 1e18, 0.0)));
  EXPECT_TRUE(std::isnan(SampleOrNan(picture, std::nan(""), 0.0)));
  EXPECT_TRUE(std::isnan(SampleOrNan(cv::Mat1b(1, 1, uint8_t{7}), 0.0, 0.0)));
}

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

TEST(IsInside, UpToTheCentresOfTheOutermostPixels) {
  const cv::Size picture(4, 3);
  EXPECT_TRUE(IsInside(0.0, 0.0, picture));
  EXPECT_TRUE(IsInside(3.0, 2.0, picture));
  EXPECT_TRUE(IsInside(1.5, 0.5, picture));
  EXPECT_FALSE(IsInside(-1e-9, 1.0, picture));
  EXPECT_FALSE(IsInside(1.0, -1e-9, picture));
  EXPECT_FALSE(IsInside(3.0 + 1e-9, 1.0, picture));
  EXPECT_FALSE(IsInside(1.0, 2.0 + 1e-9, picture));
}

TEST(IsInside, IsFalseForNanAndEmptyPictures) {
  const double nan = std::nan("");
  EXPECT_FALSE(IsInside(nan, 0.0, {4, 3}));
  EXPECT_FALSE(IsInside(0.0, nan, {4, 3}));
  EXPECT_FALSE(IsInside(0.0, 0.0, {0, 0}));
}

TEST(NodesOf, CountsEveryPixelOfTheGridThatIsInThePicture) {
  for (const int stride : {1, 2, 5, 8}) {
    for (int pixels = 0; pixels <= 30; ++pixels) {
      int count = 0;
      for (int x = stride / 2; x < pixels; x += stride) ++count;
      EXPECT_EQ(NodesOf({pixels, 40}, stride).width, count) << pixels << " / " << stride;
      EXPECT_EQ(NodesOf({40, pixels}, stride).height, count) << pixels << " / " << stride;
    }
  }
}

TEST(NodeGrid, NodesArePlacedRowByRowAndFoundAgain) {
  const int stride = 5;
  const cv::Size nodes = NodesOf({23, 12}, stride);
  ASSERT_EQ(nodes, cv::Size(5, 2));
  EXPECT_EQ(PlaceOfNode(0, nodes.width, stride), cv::Point2f(2, 2));
  EXPECT_EQ(PlaceOfNode(7, nodes.width, stride), cv::Point2f(12, 7));
  EXPECT_EQ(PlaceOfNode(cv::Point(4, 1), stride), cv::Point2f(22, 7));
  for (int node = 0; node < nodes.area(); ++node) {
    const cv::Point2f place = PlaceOfNode(node, nodes.width, stride);
    EXPECT_EQ(NodeAt(place.x, place.y, nodes.width, stride), node);
    EXPECT_EQ(NearestNode(place, nodes, stride), node);
  }
}

TEST(NearestNode, IsTheNearestAlsoOutsideOfTheGrid) {
  const cv::Size nodes(5, 2);  // columns at 2, 7, ..., 22, rows at 2 and 7
  EXPECT_EQ(NearestNode({9.4f, 2.0f}, nodes, 5), 1);
  EXPECT_EQ(NearestNode({9.6f, 2.0f}, nodes, 5), 2);
  EXPECT_EQ(NearestNode({2.0f, 4.6f}, nodes, 5), 5);
  EXPECT_EQ(NearestNode({-40.0f, -1.0f}, nodes, 5), 0);
  EXPECT_EQ(NearestNode({1000.0f, 1000.0f}, nodes, 5), 9);
}

}  // namespace
}  // namespace egosieve::vision
