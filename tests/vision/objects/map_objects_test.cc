#include "vision/objects/map_objects.h"

#include <cmath>

#include "tests/testing/status.h"

namespace egosieve::vision {
namespace {

using ::testing::HasSubstr;

// A surely moving core with a likely rim and a tail that is joined by a corner, a patch that is
// only likely, and a speck that surely moves.
cv::Mat1f Map() {
  cv::Mat1f p(20, 30, 0.1f);
  p(cv::Rect(4, 4, 6, 5)) = 0.4f;
  p(cv::Rect(5, 5, 2, 2)) = 0.9f;
  p(9, 10) = 0.3f;
  p(cv::Rect(15, 4, 8, 8)) = 0.79f;
  p(18, 2) = 0.8f;
  return p;
}

TEST(MapObjectsTest, AreLikelyAllOverAndSureSomewhere) {
  const cv::Mat1f p = Map();
  const cv::Mat1i numbers = NumberObjects(p >= 0.3f, p >= 0.8f);
  EXPECT_EQ(numbers(4, 4), 1);
  EXPECT_EQ(numbers(9, 10), 1);
  EXPECT_EQ(numbers(18, 2), 2);
  EXPECT_EQ(numbers(6, 18), 0);
  EXPECT_EQ(cv::countNonZero(numbers), 30 + 1 + 1);
}

TEST(MapObjectsTest, AreDescribedByHand) {
  const cv::Mat1f p = Map();
  const std::vector<MapObject> objects = FindObjects(p, {});
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].box, cv::Rect(4, 4, 7, 6));
  EXPECT_EQ(objects[0].pixels, 31);
  EXPECT_FLOAT_EQ(objects[0].peak, 0.9);
  EXPECT_NEAR(objects[0].mean, (26 * 0.4 + 4 * 0.9 + 0.3) / 31, 1e-6);
  const double doubt = 26 * std::sqrt(0.24) + 4 * 0.3 + std::sqrt(0.21);
  EXPECT_NEAR(objects[0].sure, 1.0 - 2.0 * doubt / 31, 1e-6);
  EXPECT_EQ(objects[1].box, cv::Rect(2, 18, 1, 1));
  EXPECT_NEAR(objects[1].sure, 0.2, 1e-6);
}

TEST(MapObjectsTest, ThresholdsHoldAsTheyAre) {
  const cv::Mat1f p = Map();
  EXPECT_EQ(FindObjects(p, {0.3, 0.79f}).size(), 3u);
  EXPECT_EQ(FindObjects(p, {0.31, 0.8})[0].pixels, 30);
  EXPECT_EQ(FindObjects(p, {0.0, 0.8}).size(), 1u);  // the whole map is one
  EXPECT_TRUE(FindObjects(cv::Mat1f(3, 3, 0.5f), {}).empty());
  EXPECT_TRUE(FindObjects(cv::Mat1f(), {}).empty());
}

TEST(MapObjectsTest, WrongThresholdsAreNamed) {
  EXPECT_TRUE(ObjectThresholds().Validate().ok());
  EXPECT_TRUE((ObjectThresholds{0.5, 0.5}).Validate().ok());
  for (const ObjectThresholds wrong :
       {ObjectThresholds{0.9, 0.8}, {-0.1, 0.8}, {0.3, 1.1}, {std::nan(""), 0.8}}) {
    EXPECT_THAT(wrong.Validate(), IsInvalid());
  }
  EXPECT_THAT(std::string((ObjectThresholds{0.9, 0.8}).Validate().message()),
              HasSubstr("--object_low=0.9"));
}

}  // namespace
}  // namespace egosieve::vision
