#include "vision/evidence/photometric_support.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gtest/gtest.h"
#include "tests/vision/evidence/road_view.h"
#include "vision/evidence/guided_match.h"

namespace egosieve::vision {
namespace {

using Places = std::vector<cv::Point2f>;

constexpr int kSide = 64;

// Smooth random texture on the left half, one grey level on the right.
cv::Mat HalfTextured() {
  cv::RNG random(7);
  cv::Mat picture(kSide, kSide, CV_8UC1);
  random.fill(picture, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(picture, picture, {5, 5}, 1.2);
  picture.colRange(kSide / 2, kSide).setTo(120);
  return picture;
}

cv::Mat Shifted(const cv::Mat& picture, int right) {
  cv::Mat moved = picture.clone();
  picture.colRange(0, kSide - right).copyTo(moved.colRange(right, kSide));
  return moved;
}

TEST(PhotometricSupport, TextureSaysWhichPlaceIsRight) {
  const cv::Mat before = HalfTextured(), now = Shifted(before, 3);
  const PhotometricSupport support(before, now, {{12, 30}}, {{15, 30}});
  EXPECT_EQ(support.noise_levels(), 1.5);  // the pictures agree: the floor
  EXPECT_GT(*support.LogRatio({12, 30}, {15, 30}, {12, 30}), 20.0);
  // Found in the wrong place, and it stands still.
  EXPECT_LT(*support.LogRatio({12, 30}, {12, 30}, {15, 30}), -20.0);
}

TEST(PhotometricSupport, NoTextureSaysNothing) {
  const cv::Mat before = HalfTextured(), now = Shifted(before, 3);
  const PhotometricSupport support(before, now, {{12, 30}}, {{15, 30}});
  EXPECT_EQ(*support.LogRatio({50, 30}, {53, 30}, {50, 30}), 0.0);
}

TEST(PhotometricSupport, BrightnessThatChangesEverywhereIsNoDifference) {
  const cv::Mat before = HalfTextured();
  cv::Mat now = Shifted(before, 3) * 0.999;
  now += 20;
  // Clipping touches the brightest pixels alone; a ratio without the change bounds it from above.
  const PhotometricSupport same(before, Shifted(before, 3), {{12, 30}}, {{15, 30}});
  const PhotometricSupport other(before, now, {{12, 30}}, {{15, 30}});
  EXPECT_GT(*other.LogRatio({12, 30}, {15, 30}, {12, 30}),
            0.5 * *same.LogRatio({12, 30}, {15, 30}, {12, 30}));
}

TEST(PhotometricSupport, TheRatioIsThatOfItsDefinition) {
  // P = 0 but for its middle, Q alike, S without: |P - S|^2 less the means by hand.
  cv::Mat before = cv::Mat::zeros(kSide, kSide, CV_8UC1);
  before.at<uint8_t>(20, 20) = 49;
  const PhotometricSupport support(before, before, {{20, 20}}, {{20, 20}});
  // E_0 = 48 (0 - (-1))^2 + (48 - 0)^2 = 48 + 2304, E_1 = N sigma^2 = 49 * 1.5^2, v = 1.5^2,
  // kappa = 1/4.
  EXPECT_NEAR(*support.LogRatio({20, 20}, {20, 20}, {40, 40}), 0.25 * (2352 - 110.25) / (2 * 2.25),
              1e-3);
}

TEST(PhotometricSupport, NoiseThatIsRepeatedSaysNothing) {
  // Of variance 2/3: a place that differs by twice that fits no worse than sigma^2 = 1.5^2.
  cv::Mat before(kSide, kSide, CV_8UC1);
  cv::RNG random(5);
  random.fill(before, cv::RNG::UNIFORM, 100, 103);
  const PhotometricSupport support(before, before, {{20, 20}}, {{20, 20}});
  EXPECT_EQ(*support.LogRatio({20, 20}, {20, 20}, {23, 20}), 0.0);
  EXPECT_EQ(*support.LogRatioOnSegment({20, 20}, {20, 20}, {{23, 20}, {29, 20}, 1.0, 1.0}), 0.0);
}

TEST(PhotometricSupport, NoiseIsThatOfWhatMoved) {
  // The left half moves and is noisy, the right half stays in place and is less so.
  cv::Mat before = HalfTextured(), now = Shifted(before, 3), noise(before.size(), CV_8UC1);
  before.colRange(kSide / 2, kSide).copyTo(now.colRange(kSide / 2, kSide));
  cv::RNG random(3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 20);  // standard deviation 5.77
  noise.colRange(kSide / 2, kSide) /= 5;
  cv::add(now, noise, now);
  Places befores, nows;
  // Most places stay.
  for (int y = 8; y < kSide - 8; y += 4) {
    for (const int x : {10, 15, 20}) {
      befores.emplace_back(x, y);
      nows.emplace_back(x + 3, y);
    }
    for (int x = 40; x < kSide - 8; x += 2) {
      befores.emplace_back(x, y);
      nows.emplace_back(x, y);
    }
  }
  const PhotometricSupport support(before, now, befores, nows);
  EXPECT_NEAR(support.noise_levels(), 5.77, 0.6);
}

TEST(PhotometricSupport, NoiseIsThatOfTheFrame) {
  const cv::Mat before = HalfTextured();
  cv::Mat now;
  cv::Mat noise(before.size(), CV_8UC1);
  cv::RNG random(3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 20);  // standard deviation 5.77
  cv::add(before, noise, now);
  std::vector<cv::Point2f> places;
  for (int y = 8; y < kSide - 8; y += 4) {
    for (int x = 36; x < kSide - 8; x += 4) places.emplace_back(x, y);
  }
  const PhotometricSupport support(before, now, places, places);
  EXPECT_NEAR(support.noise_levels(), 5.77, 0.6);
}

// Compressed video repeats what stands still to the bit: copies tell nothing of the noise.
TEST(PhotometricSupport, NoiseIsMeasuredWithoutCopies) {
  const cv::Mat before = HalfTextured();
  cv::Mat now = Shifted(before, 4);
  before.rowRange(0, kSide / 2).copyTo(now.rowRange(0, kSide / 2));  // stands still
  cv::Mat noise(kSide / 2, kSide, CV_8UC1);
  cv::RNG random(3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 20);  // standard deviation 5.77
  cv::Mat lower = now.rowRange(kSide / 2, kSide);
  cv::add(lower, noise, lower);
  std::vector<cv::Point2f> places, there;
  for (int y = 6; y < kSide - 6; y += 2) {
    if (std::abs(y - kSide / 2) < 6) continue;
    for (int x = 6; x < 24; x += 2) {
      places.emplace_back(x, y);
      there.emplace_back(y < kSide / 2 ? x : x + 4, y);
    }
  }
  EXPECT_NEAR(PhotometricSupport(before, now, places, there).noise_levels(), 5.77, 0.6);
}

// A vertical edge that moves to the right looks the same wherever along it one looks.
TEST(PhotometricSupport, WhatSlidesAlongAnEdgeFitsSomewhereOnTheSegment) {
  cv::Mat before(kSide, kSide, CV_8UC1, cv::Scalar(40));
  before.colRange(30, kSide).setTo(200);
  cv::GaussianBlur(before, before, {5, 5}, 1.0);
  const cv::Mat now = Shifted(before, 4);
  const std::vector<cv::Point2f> places = {{30, 40}}, there = {{34, 28}};
  const PhotometricSupport support(before, now, places, there);
  // Found 12 pixels up the edge; standing still it would be on a line that crosses the edge.
  EXPECT_GT(*support.LogRatio({30, 40}, {34, 28}, {30, 40}), 20.0);
  EXPECT_LT(*support.LogRatioOnSegment({30, 40}, {34, 28}, {{30, 40}, {38, 36}}), 0.1);
  // A line that the edge does not come to.
  EXPECT_GT(*support.LogRatioOnSegment({30, 40}, {34, 28}, {{30, 40}, {26, 38}}), 20.0);
}

// Half a step beside a strong edge is no evidence where the line is not known better.
TEST(PhotometricSupport, AnUncertainLineAllowsForStrongEdges) {
  const cv::Mat before = HalfTextured(), now = Shifted(before, 3);
  const std::vector<cv::Point2f> places = {{12, 30}}, there = {{15, 30}};
  const PhotometricSupport sure(before, now, places, there);
  const PhotometricSupport unsure(before, now, places, there, 0.5);
  const cv::Point2f first(15.0f, 30.6f), last(16.0f, 30.6f);
  const double of_sure = *sure.LogRatioOnSegment({12, 30}, {15, 30}, {first, last});
  const double of_unsure = *unsure.LogRatioOnSegment({12, 30}, {15, 30}, {first, last});
  EXPECT_GT(of_sure, 20.0);
  // 0.6 px off with a deviation of 0.5: kappa N / 2 (0.6 / 0.5)^2 at most, and half of it since
  // only one of the two axes is off.
  EXPECT_LT(of_unsure, 0.25 * 49.0 / 2.0 * 1.44);
}

// What comes nearer grows: a static place looks the same only at the size that its depth gives it.
TEST(PhotometricSupport, AStaticPlaceIsComparedAtItsSize) {
  const cv::Mat before = HalfTextured();
  const cv::Point2f place(16.0f, 20.0f), mover(16.0f, 46.0f);
  const double scale = 1.5;
  cv::Mat now;
  const cv::Mat1d grow =
      (cv::Mat1d(2, 3) << scale, 0, place.x * (1 - scale), 0, scale, place.y * (1 - scale));
  cv::warpAffine(before, now, grow, before.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  const cv::Rect patch(11, 15, 11, 11);
  before(patch).copyTo(now(patch + cv::Point(0, 26)));  // where flow found the place
  const PhotometricSupport support(before, now, {place}, {mover});
  const double as_it_was = *support.LogRatioOnSegment(place, mover, {place, place});
  const double grown = *support.LogRatioOnSegment(place, mover, {place, place, scale, scale});
  EXPECT_GT(as_it_was, 20.0);
  EXPECT_LT(grown, 0.1 * as_it_was);  // what two interpolations leave
}

// Bilinear level, by its definition.
double LevelAt(const cv::Mat& picture, double x, double y) {
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const double fx = x - column, fy = y - row;
  const auto at = [&](int dx, int dy) { return picture.at<uint8_t>(row + dy, column + dx); };
  return (1 - fy) * ((1 - fx) * at(0, 0) + fx * at(1, 0)) +
         fy * ((1 - fx) * at(0, 1) + fx * at(1, 1));
}

// The 49 levels around a place, `scale` pixels apart, less their mean.
std::vector<double> PatchOf(const cv::Mat& picture, cv::Point2d place, double scale) {
  std::vector<double> levels;
  double mean = 0.0;
  for (int y = -3; y <= 3; ++y) {
    for (int x = -3; x <= 3; ++x) {
      levels.push_back(LevelAt(picture, place.x + scale * x, place.y + scale * y));
      mean += levels.back() / 49.0;
    }
  }
  for (double& level : levels) level -= mean;
  return levels;
}

double Apart(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

// (S2) in float64, at places up to the picture's last columns. Places are rounded by 2e-6 pixels,
// which changes a level by 1e-4 where it changes by 50 per pixel. Where levels are 1.5 apart, as
// little as counts, 49 such errors change a squared difference by 2e-5 of itself, and the ratio by
// six times as much; twice that is allowed.
TEST(PhotometricSupport, TheRatioOnASegmentIsThatOfItsDefinition) {
  const cv::Mat before = HalfTextured(), now = Shifted(before, 1);
  const cv::Mat texture = before.colRange(0, kSide / 2).clone(), other = now.colRange(0, kSide / 2);
  for (const double last_scale : {1.0, 1.4}) {
    for (const float x : {12.3f, 26.6f, 27.9f}) {
      const cv::Point2f place(14.25f, 30.5f), found(x, 21.75f);
      const PhotometricSupport support(texture, other.clone(), {place}, {found});
      const StaticSegment segment{{8.5f, 12.25f}, {24.75f, 40.5f}, 1.0, last_scale};
      const std::vector<double> p = PatchOf(texture, place, 1.0);
      const double noise = support.noise_levels(), least = 49.0 * noise * noise;
      const double e_1 = std::max(Apart(p, PatchOf(other, found, 1.0)), least);
      const cv::Point2f way = segment.last - segment.first;
      const int steps = static_cast<int>(std::ceil(2.0 * std::hypot(way.x, way.y)));
      double e_0 = std::numeric_limits<double>::infinity();
      for (int k = 0; k <= steps; ++k) {
        const float share = static_cast<float>(k) / static_cast<float>(steps);
        double scale = std::lerp(1.0, last_scale, share);
        if (std::abs(scale - 1.0) < 0.05) scale = 1.0;
        const cv::Point2f at = segment.first + share * way;
        e_0 = std::min(e_0, Apart(p, PatchOf(other, at, scale)));
      }
      e_0 = std::max(e_0, least);
      const double ratio = std::max(0.0, 0.25 * (e_0 - e_1) / (2.0 * std::min(e_0, e_1) / 49.0));
      EXPECT_NEAR(*support.LogRatioOnSegment(place, found, segment), ratio, 2.4e-4 * (1.0 + ratio));
    }
  }
}

TEST(PhotometricSupport, ASegmentIsSearchedAsFarAsItIsInThePicture) {
  const cv::Mat before = HalfTextured(), now = Shifted(before, 3);
  const PhotometricSupport support(before, now, {{12, 30}}, {{15, 30}});
  EXPECT_EQ(*support.LogRatioOnSegment({12, 30}, {12, 30}, {{15, 30}, {-100, 30}}), 0.0);
  EXPECT_FALSE(support.LogRatioOnSegment({12, 30}, {15, 30}, {{-20, 30}, {-10, 30}}).has_value());
  EXPECT_FALSE(support.LogRatioOnSegment({2, 30}, {15, 30}, {{15, 30}, {16, 30}}).has_value());
  EXPECT_FALSE(support.LogRatioOnSegment({12, 30}, {15, 30}, {{NAN, 30}, {NAN, 31}}).has_value());
}

TEST(PhotometricSupport, NothingWhereAPatchLeavesThePicture) {
  const cv::Mat picture = HalfTextured();
  const PhotometricSupport support(picture, picture, Places(), Places());
  EXPECT_FALSE(support.LogRatio({2, 30}, {15, 30}, {15, 30}).has_value());
  EXPECT_FALSE(support.LogRatio({15, 30}, {15, 62}, {15, 30}).has_value());
  EXPECT_FALSE(support.LogRatio({15, 30}, {15, 30}, {NAN, 30}).has_value());
  EXPECT_TRUE(support.LogRatio({3, 3}, {3, 3}, {3, 3}).has_value());
}

cv::Mat Texture() {
  cv::Mat picture(kImage, CV_8UC1);
  cv::RNG random(7);
  random.fill(picture, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(picture, picture, {}, 2.0);
  cv::normalize(picture, picture, 0, 255, cv::NORM_MINMAX);
  return picture;
}

struct Scene {
  Pinhole camera = Pinhole::Of(kImage, 420);
  RelativePose pose;
  RoadPlane road;

  // Where what lies on the plane m, and is seen at (x, y) now, was seen before.
  cv::Point2d Before(const Eigen::Vector3d& m, double x, double y) const {
    const Eigen::Vector3d ray = camera.Ray(x, y);
    const Eigen::Vector3d now = ray / m.dot(ray);
    const Eigen::Vector3d before = pose.rotation.transpose() * (now - pose.translation);
    const Eigen::Vector2d place = camera.Project(before);
    return {place(0), place(1)};
  }
  // What `now` shows, as seen before: all of it on the plane m, and moved by `shift` on its own.
  cv::Mat Before(const cv::Mat& now, const Eigen::Vector3d& m, cv::Point2d shift = {}) const {
    std::vector<cv::Point2f> corners = {{100, 250}, {500, 250}, {500, 340}, {100, 340}}, moved;
    for (const cv::Point2f at : corners) moved.emplace_back(Before(m, at.x, at.y) + shift);
    cv::Mat before;
    cv::warpPerspective(now, before, cv::getPerspectiveTransform(corners, moved), kImage,
                        cv::INTER_CUBIC, cv::BORDER_REFLECT);
    return before;
  }
  std::vector<GuidedPlace> Match(const cv::Mat& before, const cv::Mat& now,
                                 const std::vector<cv::Point2f>& places) const {
    return MatchRoad(road, camera, pose, before, now, 2.0, places);
  }
};

Scene StraightAhead() {
  Scene scene;
  scene.pose.translation = -Eigen::Vector3d::UnitZ();
  scene.pose.rotation = RotationOf({0.004, -0.01, 0.003});
  scene.road.m = {0.0, kTravel / kHeight, 0.0};
  return scene;
}

std::vector<cv::Point2f> PlacesBetween(int top, int bottom) {
  std::vector<cv::Point2f> places;
  for (int y = top; y < bottom; y += 10) {
    for (int x = 60; x < kImage.width - 60; x += 10) {
      places.emplace_back(static_cast<float>(x), static_cast<float>(y));
    }
  }
  return places;
}

TEST(GuidedMatch, FindsTheRoad) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const std::vector<cv::Point2f> places = PlacesBetween(220, 350);
  const auto found = scene.Match(scene.Before(now, scene.road.m), now, places);
  EXPECT_GT(found.size(), 0.95 * places.size());
  for (const GuidedPlace& place : found) {
    const cv::Point2d before = scene.Before(scene.road.m, place.now.x, place.now.y);
    EXPECT_NEAR(place.before.x, before.x, 1e-3);
    EXPECT_NEAR(place.before.y, before.y, 1e-3);
  }
}

// What stands on the road, and what moves on it, have another motion.
TEST(GuidedMatch, FindsNothingElse) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const std::vector<cv::Point2f> places = PlacesBetween(220, 350);
  const cv::Mat wall = scene.Before(now, {0.0, 0.0, 0.6});
  EXPECT_LT(scene.Match(wall, now, places).size(), 0.02 * places.size());
  const cv::Mat moved = scene.Before(now, scene.road.m, {4.0, 0.0});
  EXPECT_LT(scene.Match(moved, now, places).size(), 0.02 * places.size());
}

TEST(GuidedMatch, ThereIsNoRoadAboveTheHorizon) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  EXPECT_TRUE(scene.Match(scene.Before(now, scene.road.m), now, PlacesBetween(20, 170)).empty());
}

TEST(GuidedMatch, BlankRoadCountsUpToWhatStandsOnIt) {
  const Scene scene = StraightAhead();
  const std::vector<cv::Point2f> places = PlacesBetween(220, 350);
  const cv::Mat blank(kImage, CV_8UC1, cv::Scalar(120));
  EXPECT_EQ(scene.Match(blank, blank, places).size(), places.size());

  // A bumper, as far in both pictures as a car ahead at equal speed, and blank above it.
  cv::Mat car = blank.clone();
  const cv::Rect bumper(200, 280, 200, 20);
  Texture()(bumper).copyTo(car(bumper));
  const auto found = scene.Match(car, car, places);
  EXPECT_LT(found.size(), places.size());
  for (const GuidedPlace& place : found) {
    const bool is_above = place.now.x > 205 && place.now.x < 395 && place.now.y < 295;
    EXPECT_FALSE(is_above) << place.now;
  }
  const auto beside = std::count_if(found.begin(), found.end(), [](const GuidedPlace& place) {
    return place.now.x < 190 || place.now.x > 410;
  });
  EXPECT_GT(beside, 300);
}

// Its edge alone moves as the road does, along which it looks the same.
TEST(GuidedMatch, ABlankDoorAboveAStraightEdgeIsNotTheRoad) {
  const Scene scene = StraightAhead();
  const cv::Rect door(200, 0, 200, 285);
  cv::Mat now(kImage, CV_8UC1, cv::Scalar(120));
  now(door).setTo(160);
  const auto found = scene.Match(scene.Before(now, scene.road.m), now, PlacesBetween(220, 350));
  int below = 0;
  for (const GuidedPlace& place : found) {
    const bool is_in_its_columns = place.now.x > door.x + 15 && place.now.x < door.br().x - 15;
    if (!is_in_its_columns) continue;
    EXPECT_GT(place.now.y, door.br().y - 4) << place.now;
    ++below;
  }
  EXPECT_EQ(below, 6 * 17);  // all of them
}

TEST(GuidedMatch, BlankRoadMayGrowBrighterSlowly) {
  const Scene scene = StraightAhead();
  cv::Mat now(kImage, CV_8UC1);
  for (int y = 0; y < now.rows; ++y) now.row(y).setTo(60 + y / 2);
  const std::vector<cv::Point2f> places = PlacesBetween(220, 350);
  EXPECT_EQ(scene.Match(scene.Before(now, scene.road.m), now, places).size(), places.size());
}

TEST(GuidedMatch, WhatGrewDarkIsNotTheRoad) {
  const Scene scene = StraightAhead();
  const cv::Mat before(kImage, CV_8UC1, cv::Scalar(120)), now(kImage, CV_8UC1, cv::Scalar(90));
  EXPECT_TRUE(scene.Match(before, now, PlacesBetween(220, 350)).empty());
}

TEST(GuidedMatch, PlacesAtTheBorderAreLeftOut) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const auto found = scene.Match(scene.Before(now, scene.road.m), now,
                                 {{0, 0}, {639, 359}, {-5, 100}, {320, 359}, {1e9f, 10}});
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace egosieve::vision
