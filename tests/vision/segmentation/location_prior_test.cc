#include "vision/segmentation/location_prior.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/testing/status.h"

namespace egosieve::vision {
namespace {

const cv::Size kSize(640, 360);

SegmentationMap MapOf(cv::Size size, float probability) {
  SegmentationMap map{.grid = ImageGrid{size.width, size.height, 5}};
  map.probability.assign(map.grid.size(), probability);
  return map;
}

// A label at each place.
void Add(LocationPrior& prior, cv::Size size, const std::vector<cv::Point2d>& places,
         double label) {
  std::vector<double> positions;
  for (const cv::Point2d place : places) {
    positions.push_back(place.x);
    positions.push_back(place.y);
  }
  const std::vector<double> labels(places.size(), label);
  prior.Add(size, {positions.data(), static_cast<int64_t>(places.size()), 2}, labels);
}

float At(const SegmentationMap& map, int x, int y) {
  return map.probability[(y / 5) * map.grid.columns() + x / 5];
}

double Odds(double p) { return p / (1.0 - p); }

std::vector<cv::Point2d> EveryCell() {
  std::vector<cv::Point2d> places;
  for (int row = 0; row < 36; ++row) {
    for (int column = 0; column < 64; ++column) {
      places.emplace_back(10.0 * column + 5.0, 10.0 * row + 5.0);
    }
  }
  return places;
}

// Labels in the left half alone, one a cell: d is twice the mean there, and none in the right half;
// 40 pixels from the border between the two the neighbourhood of d has ended.
TEST(LocationPriorTest, FactorsOfOddsByHand) {
  LocationPrior prior({0.5, 1.0});
  std::vector<cv::Point2d> left = EveryCell();
  std::erase_if(left, [](cv::Point2d place) { return place.x > 320.0; });
  constexpr int kFrames = 6;
  for (int k = 0; k < kFrames; ++k) Add(prior, kSize, left, 0.9);
  SegmentationMap map = MapOf(kSize, 0.2f);
  prior.Apply(map);
  const double inside = std::sqrt((kFrames * 2.0 + 4.0) / (kFrames + 4.0));
  const double outside = std::sqrt(4.0 / (kFrames + 4.0));
  EXPECT_NEAR(Odds(At(map, 100, 180)), 0.25 * inside, 1e-5);
  EXPECT_NEAR(Odds(At(map, 0, 0)), 0.25 * inside, 1e-5);
  EXPECT_NEAR(Odds(At(map, 500, 180)), 0.25 * outside, 1e-5);
  EXPECT_NEAR(Odds(At(map, 635, 355)), 0.25 * outside, 1e-5);
  EXPECT_GT(At(map, 300, 180), At(map, 340, 180));
}

TEST(LocationPriorTest, EvenLabelsChangeNothing) {
  LocationPrior prior({1.0, 0.99});
  for (int k = 0; k < 10; ++k) Add(prior, kSize, EveryCell(), 1.0);
  SegmentationMap map = MapOf(kSize, 0.3f);
  prior.Apply(map);
  for (const float p : map.probability) ASSERT_NEAR(p, 0.3, 1e-5);
}

TEST(LocationPriorTest, WithoutWeightOrDynamicLabelsTheMapKeepsItsBytes) {
  LocationPrior off({0.0, 0.99}), standing({0.5, 0.99}), fresh({0.5, 0.99});
  Add(off, kSize, {{100, 100}}, 1.0);
  Add(standing, kSize, {{100, 100}}, 0.49);
  for (const LocationPrior* prior : {&off, &standing, &fresh}) {
    SegmentationMap map = MapOf(kSize, 0.123f);
    prior->Apply(map);
    EXPECT_EQ(map.probability, MapOf(kSize, 0.123f).probability);
  }
}

TEST(LocationPriorTest, CertaintyStaysAndNothingLeavesTheUnitInterval) {
  LocationPrior prior({1.0, 1.0});
  for (int k = 0; k < 10000; ++k) Add(prior, kSize, {{639.9, 359.9}, {0.0, 0.0}}, 1.0);
  for (const float p : {0.0f, 1e-30f, 1e-6f, 1.0f - 1e-7f, 1.0f}) {
    SegmentationMap map = MapOf(kSize, p);
    prior.Apply(map);
    for (const float value : map.probability) {
      ASSERT_TRUE(value >= 0.0f && value <= 1.0f) << p;
      if (p == 0.0f || p == 1.0f) {
        ASSERT_EQ(value, p);
      }
    }
  }
}

TEST(LocationPriorTest, ForgetsWhereThingsMovedLongAgo) {
  LocationPrior prior({1.0, 0.9});
  Add(prior, kSize, {{100, 100}}, 1.0);
  for (int k = 0; k < 60; ++k) Add(prior, kSize, {{500, 250}}, 1.0);
  SegmentationMap map = MapOf(kSize, 0.3f);
  prior.Apply(map);
  EXPECT_GT(At(map, 500, 250), 0.9f);
  EXPECT_NEAR(At(map, 100, 100), At(map, 300, 50), 0.02);
}

TEST(LocationPriorTest, PlacesAreRelativeToTheImage) {
  LocationPrior prior({0.5, 1.0});
  Add(prior, kSize, {{160, 90}}, 1.0);
  LocationPrior of_twice({0.5, 1.0});
  Add(of_twice, kSize * 2, {{320, 180}}, 1.0);
  EXPECT_EQ(prior.ToBytes(), of_twice.ToBytes());
  SegmentationMap large = MapOf(kSize * 2, 0.3f), tiny = MapOf({1, 1}, 0.3f);
  prior.Apply(large);
  const auto greatest = std::max_element(large.probability.begin(), large.probability.end()) -
                        large.probability.begin();
  EXPECT_NEAR(static_cast<double>(greatest % large.grid.columns()) * 5, 320.0, 15.0);
  EXPECT_NEAR(static_cast<double>(greatest / large.grid.columns()) * 5, 180.0, 15.0);
  prior.Apply(tiny);
  EXPECT_TRUE(std::isfinite(tiny.probability[0]));
}

TEST(LocationPriorTest, GoesOnFromItsBytes) {
  LocationPrior prior({0.5, 0.9});
  Add(prior, kSize, {{100, 100}, {300, 200}}, 0.8);
  LocationPrior again({0.5, 0.9});
  ASSERT_TRUE(again.Restore(prior.ToBytes()).ok());
  for (LocationPrior* each : {&prior, &again}) Add(*each, kSize, {{400, 100}}, 1.0);
  SegmentationMap first = MapOf(kSize, 0.3f), second = first;
  prior.Apply(first);
  again.Apply(second);
  EXPECT_EQ(first.probability, second.probability);
  EXPECT_EQ(prior.ToBytes(), again.ToBytes());
}

TEST(LocationPriorTest, AStandingCameraTeachesNothing) {
  LabelledFrame labels;
  labels.labelled.image = cv::Mat3b(kSize, cv::Vec3b(0, 0, 0));
  labels.positions = {100.0, 100.0};
  labels.probability = {0.9};
  labels.motion_model = MotionModelKind::kStatic;
  LocationPrior prior({0.5, 1.0}), by_hand = prior;
  prior.Learn(labels);
  EXPECT_EQ(prior.ToBytes(), by_hand.ToBytes());
  labels.motion_model = MotionModelKind::kFundamental;
  prior.Learn(labels);
  prior.Learn({});  // a frame without labels
  Add(by_hand, kSize, {{100.0, 100.0}}, 0.9);
  EXPECT_EQ(prior.ToBytes(), by_hand.ToBytes());
}

TEST(LocationPriorTest, BytesThatAreNoStateAreRefused) {
  LocationPrior prior({0.5, 0.9});
  Add(prior, kSize, {{100, 100}}, 1.0);
  const std::string before = prior.ToBytes();
  std::string torn = before, infinite = before, negative = before;
  torn.pop_back();
  const float wrong[] = {std::numeric_limits<float>::infinity(), -1.0f};
  infinite.replace(infinite.size() - 4, 4, reinterpret_cast<const char*>(&wrong[0]), 4);
  negative.replace(negative.size() - 4, 4, reinterpret_cast<const char*>(&wrong[1]), 4);
  for (const std::string& bytes : {std::string(), torn, before + "x", infinite, negative}) {
    EXPECT_THAT(prior.Restore(bytes), IsInvalid());
    EXPECT_EQ(prior.ToBytes(), before);
  }
}

}  // namespace
}  // namespace egosieve::vision
