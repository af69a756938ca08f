#include "vision/own_vehicle/own_vehicle.h"

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gmock/gmock.h"
#include "vision/own_vehicle/fixed_pattern.h"

namespace egosieve::vision {
namespace {

constexpr int kWidth = 160, kHeight = 120;
const cv::Rect kPanel(20, 84, 120, 24);  // fixed, with texture
const cv::Rect kSky(0, 0, kWidth, 24);   // blank

cv::Mat1b Texture(cv::Size size, uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat1b texture(size);
  random.fill(texture, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(texture, texture, {}, 1.2);
  return texture;
}

// A world that goes by and a panel that stays, `sway` pixels to and fro.
std::vector<cv::Mat1b> Drive(int count, double sway) {
  const cv::Mat1b world = Texture({kWidth + 40 * count, kHeight}, 1);
  const cv::Mat1b panel = Texture({kPanel.width + 8, kPanel.height + 8}, 2);
  std::vector<cv::Mat1b> pictures;
  for (int k = 0; k < count; ++k) {
    cv::Mat1b picture = world(cv::Rect(37 * k, 0, kWidth, kHeight)).clone();
    picture(kSky) = 200;
    const double shift = sway * std::sin(1.7 * k);
    cv::Mat1b moved;
    const cv::Mat1d transform = (cv::Mat1d(2, 3) << 1, 0, shift, 0, 1, 0.5 * shift);
    cv::warpAffine(panel, moved, transform, panel.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
    moved(cv::Rect(4, 4, kPanel.width, kPanel.height)).copyTo(picture(kPanel));
    pictures.push_back(picture);
  }
  return pictures;
}

double ShareOf(const FixedPlaces& places, FixedPlaces::Kind kind, cv::Rect area) {
  return static_cast<double>(cv::countNonZero(places.kind(area) == kind)) / area.area();
}

// Without the rim that the window blurs.
cv::Rect Inner(cv::Rect area) {
  return {area.x + 6, area.y + 6, area.width - 12, area.height - 12};
}

FixedPlaces Find(const std::vector<cv::Mat1b>& pictures) {
  return FindFixedPlaces(pictures, {kWidth, kHeight});
}

TEST(FixedPlaces, WhatStaysIsFixedWhatGoesByChangesAndTheSkyIsBlank) {
  const FixedPlaces places = Find(Drive(20, 0.0));
  EXPECT_GT(ShareOf(places, FixedPlaces::kFixed, Inner(kPanel)), 0.95);
  EXPECT_GT(ShareOf(places, FixedPlaces::kChanging, {0, 36, kWidth, 36}), 0.95);
  EXPECT_EQ(ShareOf(places, FixedPlaces::kFixed, {0, 36, kWidth, 36}), 0.0);
  EXPECT_EQ(ShareOf(places, FixedPlaces::kBlank, {0, 0, kWidth, 16}), 1.0);
  EXPECT_TRUE(places.IsFixed(80, 96));
  EXPECT_FALSE(places.IsFixed(80, 50));
  EXPECT_FALSE(places.IsFixed(-3, 96));
}

TEST(FixedPlaces, WhatSwaysIsNotFixed) {
  // As a vehicle that is followed does, by much less than its size.
  const FixedPlaces places = Find(Drive(20, 1.5));
  EXPECT_LT(ShareOf(places, FixedPlaces::kFixed, Inner(kPanel)), 0.02);
}

TEST(FixedPlaces, AFractionOfAPixelIsFollowing) {
  // Each window may agree; the patch as a whole does not stay.
  EXPECT_EQ(ShareOf(Find(Drive(20, 0.6)), FixedPlaces::kFixed, Inner(kPanel)), 0.0);
  EXPECT_GT(ShareOf(Find(Drive(20, 0.2)), FixedPlaces::kFixed, Inner(kPanel)), 0.95);
}

TEST(FixedPlaces, ThinLettersOverASceneThatGoesByAreFixed) {
  constexpr int kPictures = 6;  // of a clip of half a second
  const cv::Rect caption(30, 40, 100, 24);
  std::vector<cv::Mat1b> pictures = Drive(kPictures, 0.0);
  cv::Mat1b letters = cv::Mat1b::zeros(kHeight, kWidth);
  cv::putText(letters, "14:03:07", {32, 59}, cv::FONT_HERSHEY_SIMPLEX, 0.7, 255, 2);
  for (cv::Mat1b& picture : pictures) {
    picture(caption) *= 0.3;  // of less contrast than the letters
    const cv::Mat1b lit = 0.3 * picture + 0.7 * letters;
    lit.copyTo(picture, letters);
  }
  const FixedPlaces places = Find(pictures);
  EXPECT_EQ(cv::countNonZero((places.kind != FixedPlaces::kFixed) & letters), 0);
  EXPECT_EQ(ShareOf(places, FixedPlaces::kFixed, {0, 30, 24, 50}), 0.0);
  EXPECT_TRUE(places.median.empty());  // too few pictures for the windscreen's reflections
}

TEST(FixedPlaces, OnAShakingMountWhatSwaysInTheLowestPartIsFixed) {
  const std::vector<cv::Mat1b> pictures = Drive(20, 2.5);
  const FixedPlaces places = FindFixedOnMount(pictures, {kWidth, kHeight});
  ASSERT_EQ(places.shakes.size(), pictures.size());
  EXPECT_GT(ShareOf(places, FixedPlaces::kFixed, Inner(kPanel)), 0.7);
  EXPECT_EQ(ShareOf(places, FixedPlaces::kFixed, {0, 36, kWidth, 36}), 0.0);
  const cv::Vec3f middle(kPanel.x + 0.5f * kPanel.width, kPanel.y + 0.5f * kPanel.height, 1.0f);
  const cv::Vec2f first = places.shakes[0] * middle;
  for (size_t k = 0; k < places.shakes.size(); ++k) {
    const cv::Vec2f moved = places.shakes[k] * middle - first;
    const double shift = 2.5 * std::sin(1.7 * static_cast<double>(k));
    EXPECT_NEAR(moved(0), shift, 0.4) << k;
    EXPECT_NEAR(moved(1), 0.5 * shift, 0.4) << k;
  }
  EXPECT_TRUE(FindFixedOnMount(Drive(20, 0.0), {kWidth, kHeight}).kind.empty());
}

TEST(FixedPlaces, AFewPicturesSayNothing) {
  const FixedPlaces places = Find(Drive(kFewestPictures - 1, 0.0));
  EXPECT_TRUE(places.kind.empty());
  EXPECT_FALSE(places.IsFixed(80, 96));
  EXPECT_TRUE(ProveOwnVehicle(places, {}, Pinhole::Of({kWidth, kHeight}, 150)).empty());
}

// Everything fixed, with edges across `normal`.
FixedPlaces AllFixed(const Eigen::Vector2d& normal) {
  return {.image = {kWidth, kHeight},
          .kind = cv::Mat1b(kHeight, kWidth, FixedPlaces::kFixed),
          .s_xx = cv::Mat1f(kHeight, kWidth, static_cast<float>(normal(0) * normal(0))),
          .s_xy = cv::Mat1f(kHeight, kWidth, static_cast<float>(normal(0) * normal(1))),
          .s_yy = cv::Mat1f(kHeight, kWidth, static_cast<float>(normal(1) * normal(1)))};
}

std::vector<PairWorld> Worlds(double turn, double ground_slope) {
  PairWorld world;
  world.motion.found = true;
  world.motion.rotation = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitX()).toRotationMatrix();
  world.motion.translation = -Eigen::Vector3d::UnitZ();
  world.ground_slope = ground_slope;
  return std::vector<PairWorld>(20, world);
}

cv::Mat1b Prove(const FixedPlaces& places, const std::vector<PairWorld>& worlds) {
  return ProveOwnVehicle(places, worlds, Pinhole::Of(places.image, 150.0));
}

TEST(OwnVehicle, BelowTheHorizonTheGroundWouldMove) {
  const cv::Mat1b own = Prove(AllFixed(Eigen::Vector2d(0, 1)), Worlds(0.0, 0.2));
  ASSERT_FALSE(own.empty());
  EXPECT_NE(own(110, 80), 0);
  EXPECT_EQ(own(20, 80), 0);  // may be far away
}

TEST(OwnVehicle, ALineThatLeadsToWhereTheCameraMovesIsWorld) {
  // A lane's line straight below the principal point: the ground moves along it.
  const cv::Mat1b own = Prove(AllFixed(Eigen::Vector2d(1, 0)), Worlds(0.0, 0.2));
  ASSERT_FALSE(own.empty());
  EXPECT_EQ(own(110, 79), 0);
  EXPECT_NE(own(110, 20), 0);
}

TEST(OwnVehicle, InSteadyPicturesALineThatLeadsTwoDegreesAsideIsWorld) {
  std::vector<PairWorld> worlds = Worlds(0.0, 0.2);
  for (PairWorld& world : worlds) world.times = 5.0;
  FixedPlaces places = AllFixed(Eigen::Vector2d(std::cos(0.035), std::sin(0.035)));
  places.shakes = {{1, 0, 0, 0, 1, 0}};
  const cv::Mat1b own = Prove(places, worlds);
  ASSERT_FALSE(own.empty());
  EXPECT_EQ(own(110, 79), 0);
  EXPECT_NE(own(110, 20), 0);
}

TEST(OwnVehicle, OfAShakingMountItIsWhereAnyPictureHasIt) {
  FixedPlaces places = AllFixed(Eigen::Vector2d(0, 1));
  places.kind(cv::Rect(0, 0, kWidth, 100)) = FixedPlaces::kChanging;
  places.shakes = {{1, 0, 0, 0, 1, 0}, {1, 0, 0, 0, 1, -5}};
  const cv::Mat1b own = Prove(places, Worlds(0.0, 0.2));
  ASSERT_FALSE(own.empty());
  EXPECT_NE(own(96, 80), 0);
  EXPECT_EQ(own(92, 80), 0);
  // The pictures are steady by their own rotation, so a turn shows nothing.
  EXPECT_TRUE(Prove(places, Worlds(-0.01, 0.0)).empty());
}

TEST(OwnVehicle, ATurnMovesWhatIsFarAway) {
  EXPECT_TRUE(Prove(AllFixed(Eigen::Vector2d(0, 1)), Worlds(0.0, 0.0)).empty());
  const cv::Mat1b own = Prove(AllFixed(Eigen::Vector2d(0, 1)), Worlds(0.01, 0.0));
  ASSERT_FALSE(own.empty());
  // Above, the translation may undo the turn, for some depth; not below.
  EXPECT_NE(own(59, 80), 0);
}

TEST(OwnVehicle, BlankPartsThatItEnclosesBelongToIt) {
  FixedPlaces places = AllFixed(Eigen::Vector2d(0, 1));
  places.kind(cv::Rect(0, 0, kWidth, 70)) = FixedPlaces::kChanging;
  const cv::Rect bonnet(40, 95, 80, 25);
  places.kind(bonnet) = FixedPlaces::kBlank;  // reaches the lower edge
  const cv::Rect sky(0, 0, kWidth, 20);
  places.kind(sky) = FixedPlaces::kBlank;
  const cv::Mat1b own = Prove(places, Worlds(0.0, 0.2));
  ASSERT_FALSE(own.empty());
  EXPECT_EQ(cv::countNonZero(own(bonnet)), bonnet.area());
  EXPECT_EQ(cv::countNonZero(own(sky)), 0);
}

TEST(OwnVehicle, APatchNotMuchLargerThanTheWindowIsChance) {
  FixedPlaces places = AllFixed(Eigen::Vector2d(0, 1));
  places.kind = FixedPlaces::kChanging;
  places.kind(cv::Rect(70, 100, 14, 14)) = FixedPlaces::kFixed;
  EXPECT_TRUE(Prove(places, Worlds(0.0, 0.2)).empty());
  places.kind(cv::Rect(70, 90, 24, 24)) = FixedPlaces::kFixed;
  EXPECT_FALSE(Prove(places, Worlds(0.0, 0.2)).empty());
}

TEST(OwnVehicle, ABlankBonnetIsFoundByItsEdge) {
  std::vector<cv::Mat1b> pictures = Drive(20, 0.0);
  const cv::Rect bonnet(0, 90, kWidth, 30);
  cv::RNG noise(5);
  for (cv::Mat1b& picture : pictures) {
    cv::Mat1b grain(bonnet.size());
    noise.fill(grain, cv::RNG::NORMAL, 30, 5);  // smoothed, below the least contrast
    grain.copyTo(picture(bonnet));
  }
  const cv::Mat1b own = Prove(Find(pictures), Worlds(0.0, 0.2));
  ASSERT_FALSE(own.empty());
  EXPECT_GT(cv::countNonZero(own(bonnet)), 0.8 * bonnet.area());
  EXPECT_LT(cv::countNonZero(own(cv::Rect(0, 0, kWidth, 80))), 0.01 * kWidth * 80);
}

const cv::Size kPatternSize(120, 80);
const cv::Rect kCovered(30, 20, 40, 30);

double AgreeingShare(const cv::Mat1b& median, const cv::Mat1b& picture, cv::Rect area) {
  const FixedPattern pattern(SmoothPicture(median));
  const cv::Mat1b agreeing = pattern.Agreeing(SmoothPicture(picture));
  return static_cast<double>(cv::countNonZero(agreeing(area))) / area.area();
}

TEST(FixedPattern, AgreesInAnyLight) {
  const cv::Mat1b median = Texture(kPatternSize, 1);
  cv::Mat1b darker;
  median.convertTo(darker, CV_8U, 0.6, 20.0);
  EXPECT_GT(AgreeingShare(median, darker, {{}, kPatternSize}), 0.99);
}

TEST(FixedPattern, ALineStaysWhateverItsLengthHides) {
  // The edge of a black bar, with noise.
  cv::RNG random(4);
  const auto bar = [&random](double noise) {
    cv::Mat1f picture(kPatternSize);
    random.fill(picture, cv::RNG::NORMAL, 100.0, noise);
    picture.colRange(0, 30) = 0.0f;
    cv::GaussianBlur(picture, picture, {}, 1.0);
    return picture;
  };
  std::vector<cv::Point> patch;
  for (int y = 10; y < 70; ++y) {
    for (int x = 25; x < 35; ++x) patch.emplace_back(x, y);
  }
  const FixedPattern pattern(bar(0.05));  // a median has little
  EXPECT_LT(cv::norm(pattern.Shifts(bar(2.0), {patch})[0]), 0.1);
}

// Waves, shifted by exactly `shift`.
cv::Mat1f Waves(cv::Vec2d shift) {
  cv::Mat1f waves(kPatternSize);
  for (int y = 0; y < waves.rows; ++y) {
    for (int x = 0; x < waves.cols; ++x) {
      const double u = x + shift(0), v = y + shift(1);
      waves(y, x) = static_cast<float>(60.0 * std::sin(0.3 * u + 0.2 * v) +
                                       40.0 * std::sin(0.35 * v - 0.1 * u));
    }
  }
  return waves;
}

TEST(FixedPattern, KnowsTheShiftOfAPatch) {
  std::vector<cv::Point> patch;
  for (int y = 25; y < 45; ++y) {
    for (int x = 40; x < 80; ++x) patch.emplace_back(x, y);
  }
  const cv::Mat1f darker = 0.5 * Waves({0.3, -0.2}) + 40.0;
  const FixedPattern pattern(Waves({0, 0}));
  EXPECT_NEAR(cv::norm(pattern.Shifts(Waves({0, 0}), {patch})[0]), 0.0, 1e-5);
  const cv::Vec2d shift = pattern.Shifts(darker, {patch})[0];
  EXPECT_NEAR(shift(0), 0.3, 0.02);
  EXPECT_NEAR(shift(1), -0.2, 0.02);
  EXPECT_TRUE(std::isinf(pattern.Shifts(cv::Mat1f::ones(kPatternSize), {patch})[0](0)));
}

TEST(FixedPattern, DoesNotAgreeWithWhatCoversIt) {
  const cv::Mat1b median = Texture(kPatternSize, 1);
  cv::Mat1b covered = median.clone();
  Texture(kPatternSize, 2)(kCovered).copyTo(covered(kCovered));
  const int margin = kFixedPatternWindow / 2;
  const cv::Rect inner(kCovered.x + margin, kCovered.y + margin, kCovered.width - 2 * margin,
                       kCovered.height - 2 * margin);
  EXPECT_LT(AgreeingShare(median, covered, inner), 0.2);  // some windows are alike by chance
  EXPECT_GT(AgreeingShare(median, covered, {80, 0, 40, kPatternSize.height}), 0.99);
}

TEST(FixedPattern, DoesNotAgreeWithItselfAPixelAside) {
  const cv::Mat1b median = Texture(kPatternSize, 1);
  cv::Mat1b aside;
  const cv::Mat1d shift = (cv::Mat1d(2, 3) << 1, 0, 1, 0, 1, 0);
  cv::warpAffine(median, aside, shift, median.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  EXPECT_LT(AgreeingShare(median, aside, {20, 20, 80, 40}), 0.05);
}

}  // namespace
}  // namespace egosieve::vision
