#include "vision/matching/scene_agreement.h"

#include <gtest/gtest.h>

namespace egosieve::vision {
namespace {

const cv::Size kSize(800, 400);

// A point every 10 pixels: 100 an area. Of each area's, every `period`-th agrees, where `in` says.
template <typename In>
void Fill(int period, const In& in, bool as_features, SceneAgreement& scene) {
  int count = 0;
  for (int y = 5; y < kSize.height; y += 10) {
    for (int x = 5; x < kSize.width; x += 10) {
      const bool agrees = in(x, y) && ++count % period == 0;
      const cv::Point2f place(static_cast<float>(x), static_cast<float>(y));
      as_features ? scene.AddFeature(place, agrees) : scene.AddFlow(place, agrees);
    }
  }
}

bool Everywhere(int, int) { return true; }

TEST(SceneAgreement, ChanceIsNoSceneAndAThirdIs) {
  for (const bool features : {false, true}) {
    for (const int period : {1, 3, features ? 12 : 4}) {
      SceneAgreement scene(kSize);
      Fill(period, Everywhere, features, scene);
      EXPECT_EQ(scene.CountAreas().judged, 32);
      EXPECT_TRUE(scene.IsOneScene()) << features << period;
    }
    SceneAgreement chance(kSize);
    Fill(features ? 50 : 6, Everywhere, features, chance);
    EXPECT_FALSE(chance.IsOneScene()) << features;
  }
}

// A bonnet across the lower quarter agrees in full, and nothing above it.
TEST(SceneAgreement, WhatIsFixedToTheCameraIsNoScene) {
  for (const bool features : {false, true}) {
    SceneAgreement scene(kSize);
    Fill(
        1, [](int, int y) { return y >= 300; }, features, scene);
    EXPECT_EQ(scene.CountAreas().holding, 8);
    EXPECT_FALSE(scene.IsOneScene());
    Fill(
        1, [](int x, int y) { return x < 400 || y >= 300; }, !features, scene);
    EXPECT_TRUE(scene.IsOneScene()) << "either source suffices";
  }
}

// Sky: what holds no points has no say.
TEST(SceneAgreement, AreasWithoutPointsDoNotCount) {
  SceneAgreement scene(kSize);
  for (int x = 5; x < kSize.width; x += 5) {
    for (const int y : {310, 330, 350}) scene.AddFlow({static_cast<float>(x), 1.0F * y}, true);
  }
  EXPECT_EQ(scene.CountAreas().judged, 8);
  EXPECT_TRUE(scene.IsOneScene());
}

// Too small, or too little texture, for areas: the picture is judged as one.
TEST(SceneAgreement, LittleIsJudgedAsAWhole) {
  for (const int agreeing : {0, 2, 3, 12}) {
    SceneAgreement scene(kSize);
    for (int i = 0; i < 12; ++i) scene.AddFlow({300.0F + 3 * i, 200}, i < agreeing);
    EXPECT_EQ(scene.CountAreas().judged, 1);
    EXPECT_EQ(scene.IsOneScene(), agreeing >= 3) << agreeing;
  }
  SceneAgreement empty(kSize), outside(kSize);
  EXPECT_FALSE(empty.IsOneScene());
  for (int i = 0; i < 40; ++i) outside.AddFeature({-1e9F, 1e9F}, true);
  EXPECT_TRUE(outside.IsOneScene()) << "places outside belong to the border's areas";
}

}  // namespace
}  // namespace egosieve::vision
