#include "vision/image/bilinear.h"

#include <cmath>
#include <cstdint>
#include <random>

#include "gtest/gtest.h"

namespace egosieve::vision {
namespace {

// 10 20 40
//  0 30 80
cv::Mat1b Picture() { return (cv::Mat1b(2, 3) << 10, 20, 40, 0, 30, 80); }

TEST(AroundClamped, IsTheWholePositionBeforeAndTheNext) {
  const Around<double> middle = AroundClamped(3.25, 6);
  EXPECT_EQ(middle.low, 3);
  EXPECT_EQ(middle.high, 4);
  EXPECT_EQ(middle.share, 0.25);
  const Around<double> whole = AroundClamped(3.0, 6);
  EXPECT_EQ(whole.low, 3);
  EXPECT_EQ(whole.share, 0.0);
}

TEST(AroundClamped, TheLastPositionIsInAPairOrAlone) {
  for (const float at : {5.0f, 5.5f, 1e9f}) {
    const Around<float> pair = AroundClamped(at, 6);
    EXPECT_EQ(pair.low, 4) << at;
    EXPECT_EQ(pair.high, 5) << at;
    EXPECT_EQ(pair.share, 1.0f) << at;
    const Around<float> alone = AroundClamped<AtLast::kAlone>(at, 6);
    EXPECT_EQ(alone.low, 5) << at;
    EXPECT_EQ(alone.high, 5) << at;
    EXPECT_EQ(alone.share, 0.0f) << at;
  }
  const Around<float> before = AroundClamped<AtLast::kAlone>(4.5f, 6);
  EXPECT_EQ(before.low, 4);
  EXPECT_EQ(before.high, 5);
}

TEST(AroundClamped, OutsideAndOfOneValueItIsTheNearest) {
  for (const float at : {-0.5f, -1e9f}) {
    const Around<float> first = AroundClamped(at, 6);
    EXPECT_EQ(first.low, 0) << at;
    EXPECT_EQ(first.share, 0.0f) << at;
  }
  for (const float at : {-2.0f, 0.0f, 0.7f}) {
    const Around<float> single = AroundClamped(at, 1);
    EXPECT_EQ(single.low, 0) << at;
    EXPECT_EQ(single.high, 0) << at;
    EXPECT_EQ(single.share, 0.0f) << at;
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

}  // namespace
}  // namespace egosieve::vision
