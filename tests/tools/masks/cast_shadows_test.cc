// A grey ground, a mover that stands on it, and what is dark around it.
#include "tools/masks/cast_shadows.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace egosieve::tools {
namespace {

const cv::Size kSize(300, 200);
const cv::Rect kMover(140, 40, 30, 80);  // its feet at y = 120

class CastShadows : public testing::Test {
 protected:
  CastShadows() : picture_(kSize, cv::Vec3b(150, 160, 170)), moving_(kSize, uint8_t{0}) {
    Darken(kMover, 0.3);
    moving_(kMover) = 255;
  }

  void Darken(const cv::Rect& where, double share) {
    cv::Mat part = picture_(where);
    part *= share;
  }

  // Of a rectangle's pixels, less those of the mover.
  static double Share(const cv::Mat1b& shadows, const cv::Rect& where) {
    cv::Mat1b counted(kSize, uint8_t{0});
    counted(where) = 255;
    counted(kMover) = 0;
    return static_cast<double>(cv::countNonZero(shadows & counted)) / cv::countNonZero(counted);
  }

  cv::Mat3b picture_;
  cv::Mat1b moving_;
};

TEST_F(CastShadows, AreFoundWhereTheyBeginAtTheFeet) {
  const cv::Rect shadow(90, 112, 60, 20), stone(210, 110, 20, 20);
  Darken(shadow, 0.4);
  Darken(stone, 0.4);
  const cv::Mat1b found = FindCastShadows(picture_, moving_, 80);
  EXPECT_GT(Share(found, shadow), 0.85) << "smoothing takes a pixel at each edge";
  EXPECT_EQ(Share(found, stone), 0.0) << "it does not reach the feet";
  EXPECT_EQ(cv::countNonZero(found & moving_), 0) << "the mover is none";
  EXPECT_LT(cv::countNonZero(found), 1.1 * shadow.area()) << "and adds nothing";
}

TEST_F(CastShadows, EndAtTheMargin) {
  const cv::Rect shadow(20, 110, 120, 12);
  Darken(shadow, 0.4);
  const cv::Mat1b found = FindCastShadows(picture_, moving_, 50);
  EXPECT_GT(Share(found, {91, 110, 49, 12}), 0.8);
  EXPECT_EQ(Share(found, {20, 110, 69, 12}), 0.0);
  EXPECT_EQ(cv::countNonZero(FindCastShadows(picture_, moving_, 0)), 0);
}

// A hedge behind the mover; a puddle that is hardly darker; the next mover.
TEST_F(CastShadows, AreOnTheGroundAndDark) {
  const cv::Rect hedge(60, 50, 160, 40), puddle(100, 121, 100, 20);
  Darken(hedge, 0.3);
  Darken(puddle, 0.75);
  const cv::Mat1b found = FindCastShadows(picture_, moving_, 60);
  EXPECT_EQ(Share(found, hedge), 0.0);
  EXPECT_EQ(Share(found, puddle), 0.0);
  const cv::Rect next(172, 90, 20, 40);
  Darken(next, 0.3);
  moving_(next) = 255;
  EXPECT_EQ(Share(FindCastShadows(picture_, moving_, 60), next), 0.0);
}

TEST_F(CastShadows, OfSpecksAndAtTheEdgeDoNoHarm) {
  cv::Mat1b speck(kSize, uint8_t{0});
  speck(cv::Rect(150, 100, 7, 7)) = 255;
  Darken({100, 105, 60, 10}, 0.4);
  EXPECT_EQ(cv::countNonZero(FindCastShadows(picture_, speck, 60)), 0);
  cv::Mat1b all(kSize, uint8_t{255}), corner(kSize, uint8_t{0});
  EXPECT_EQ(cv::countNonZero(FindCastShadows(picture_, all, 60)), 0);
  corner(cv::Rect(290, 190, 10, 10)) = 255;
  EXPECT_EQ(cv::countNonZero(FindCastShadows(picture_, corner, 60)), 0);
}

}  // namespace
}  // namespace egosieve::tools
