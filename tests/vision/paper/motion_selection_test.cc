#include "vision/paper/motion_selection.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <vector>

#include "absl/strings/str_format.h"
#include "tests/testing/status.h"
#include "tests/vision/geometry/synthetic_pairs.h"
#include "vision/geometry/residual.h"

namespace egosieve::vision {
namespace {

using testing::CameraMotion;
using testing::MakeSyntheticPairs;
using testing::SyntheticOptions;

constexpr struct {
  CameraMotion motion;
  const char* name;
  MotionModelKind expected;
} kCases[] = {{CameraMotion::kStatic, "static", MotionModelKind::kStatic},
              {CameraMotion::kRotation, "rotation", MotionModelKind::kHomography},
              {CameraMotion::kPlanar, "planar", MotionModelKind::kHomography},
              {CameraMotion::kForward, "forward", MotionModelKind::kFundamental},
              {CameraMotion::kSideways, "sideways", MotionModelKind::kFundamental}};

// 1000 pairs of frames: five motions, movers 0 to 40 %, noise 0 to 1 pixel.
TEST(SelectMotion, ChoosesTheRightModel) {
  constexpr int kPerMotion = 200;
  int right = 0;
  for (const auto& test_case : kCases) {
    std::map<MotionModelKind, int> chosen;
    for (int i = 0; i < kPerMotion; ++i) {
      const SyntheticOptions scene{.motion = test_case.motion,
                                   .count = 1200,
                                   .mover_share = 0.4 * (i % 9) / 8.0,
                                   .noise_pixels = (i % 11) / 10.0,
                                   .seed = 1000u + i};
      const auto model = Value(SelectMotion(MakeSyntheticPairs(scene).pairs, i));
      EXPECT_TRUE(model.trusted) << test_case.name << " " << i << ": " << model.reason;
      ++chosen[model.kind];
      right += model.kind == test_case.expected;
      if (model.kind != test_case.expected) {
        std::printf("%s: movers %.2f noise %.1f seed %d chose %s\n", test_case.name,
                    scene.mover_share, scene.noise_pixels, i, Name(model.kind));
      }
    }
    std::printf("%-9s static %3d  homography %3d  fundamental %3d\n", test_case.name,
                chosen[MotionModelKind::kStatic], chosen[MotionModelKind::kHomography],
                chosen[MotionModelKind::kFundamental]);
  }
  EXPECT_GE(right, 990) << "of 1000";
}

TEST(FitFundamental, GivesOneWithoutParallaxToo) {
  const SyntheticOptions scene{.motion = CameraMotion::kRotation};
  const auto model = FitFundamental(MakeSyntheticPairs(scene).pairs, 1);
  EXPECT_EQ(model->kind, MotionModelKind::kFundamental);
  EXPECT_EQ(model->parallax_pixels, 0.0);
}

TEST(SelectMotion, ParallaxIsTheNoiseWithoutTranslationAndMoreWithIt) {
  SyntheticOptions scene{
      .motion = CameraMotion::kRotation, .mover_share = 0.1, .noise_pixels = 0.2};
  // The median of a Rayleigh variable is 1.18 sigma, sigma = 0.2 sqrt 2; movers and the fit: +- a
  // third.
  EXPECT_NEAR(SelectMotion(MakeSyntheticPairs(scene).pairs, 1)->parallax_pixels, 0.33, 0.11);
  scene.motion = CameraMotion::kSideways;
  EXPECT_GT(SelectMotion(MakeSyntheticPairs(scene).pairs, 1)->parallax_pixels, 3.0);
}

// A still camera and two fifths of the picture that all moves to the right, at different speeds: a
// fundamental matrix with horizontal lines explains everything.
std::vector<PointPair> StillAmongParallelMovers(double shift_of_rest) {
  std::vector<PointPair> pairs;
  for (int y = 10; y < 370; y += 12) {
    for (int x = 10; x < 1230; x += 12) {
      const double moved = x % 5 < 2 ? 4.0 + (y % 7) : shift_of_rest;
      const double noise = 0.05 * std::sin(37.0 * x + 11.0 * y);
      pairs.push_back({1.0 * x, 1.0 * y, x + moved + noise, y + 0.5 * noise});
    }
  }
  return pairs;
}

TEST(SelectMotion, CameraAmongParallelMoversStandsStill) {
  const auto model = Value(SelectMotion(StillAmongParallelMovers(0.0), 1));
  EXPECT_EQ(model.kind, MotionModelKind::kStatic);
  EXPECT_TRUE(model.trusted);
  // What hardly moves is not still.
  EXPECT_NE(SelectMotion(StillAmongParallelMovers(0.6), 1)->kind, MotionModelKind::kStatic);
}

TEST(SelectMotion, NoMajorityIsNotTrusted) {
  const SyntheticOptions scene{.mover_share = 0.0, .outlier_share = 0.95};
  const auto model = Value(SelectMotion(MakeSyntheticPairs(scene).pairs, 1));
  EXPECT_FALSE(model.trusted);
  EXPECT_EQ(model.reason,
            absl::StrFormat("only %.0f %% of the matches agree on one motion of the camera",
                            100.0 * model.inlier_count / model.pair_count));
}

TEST(SelectMotion, FewAndDegeneratePairsGiveADefinedResult) {
  for (int count = 0; count <= 8; ++count) {
    std::vector<PointPair> pairs;
    for (int i = 0; i < count; ++i) {
      pairs.push_back({37.0 * i, 11.0 * i * i, 40.0 * i + 1, 11.0 * i * i + 2});
    }
    EXPECT_TRUE(SelectMotion(pairs, 1).ok()) << count;
  }
  const std::vector<PointPair> identical(500, PointPair{5, 6, 7, 8});
  std::vector<PointPair> collinear, not_finite(50, PointPair{1, NAN, 2, 3});
  for (int i = 0; i < 500; ++i) collinear.push_back({1.0 * i, 2.0 * i, 1.0 * i + 3, 2.0 * i + 6});
  for (const auto& pairs : {identical, collinear, not_finite}) {
    EXPECT_TRUE(SelectMotion(pairs, 1).ok());
    const auto fundamental = Value(FitFundamental(pairs, 1));
    if (fundamental.kind == MotionModelKind::kNone) {
      EXPECT_FALSE(fundamental.trusted);
      EXPECT_FALSE(fundamental.reason.empty());
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
