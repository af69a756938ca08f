#include "vision/evidence/three_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/vision/evidence/point_street.h"

namespace egosieve::vision {
namespace {

PointTriple TripleOf(const PointStreet& street, int64_t i, int a, int b, int c) {
  return {street.Place(i, a), street.Place(i, b), street.Place(i, c)};
}

struct Fit {
  std::vector<PointTriple> triples;
  std::vector<int64_t> indices;
  ThreeViewMotion motion;
};

Fit FitStreet(const PointStreet& street, int a, int b, int c) {
  Fit fit;
  for (int64_t i = 0; i < street.size(); ++i) {
    if (!street.SeenIn(i, a, c)) continue;
    fit.triples.push_back(TripleOf(street, i, a, b, c));
    fit.indices.push_back(i);
  }
  const RelativePose first =
      EstimateRelativePose(street.Pairs(a, b), street.Fundamental(a, b), street.camera(), {});
  const RelativePose second =
      EstimateRelativePose(street.Pairs(b, c), street.Fundamental(b, c), street.camera(), {});
  fit.motion = FitThreeViews(fit.triples, first, second, street.camera(), {});
  return fit;
}

TEST(ThreeView, ExactStaticPointsHaveNoResidualAndTheScaleIsFound) {
  const PointStreet street(StreetOptions{});
  // From 0 to 3 the camera travels half as far again as from 3 to 5.
  const Fit fit = FitStreet(street, 0, 3, 5);
  ASSERT_TRUE(fit.motion.found);
  EXPECT_NEAR(fit.motion.speed_ratio, 2.0 / 3, 1e-6);
  for (const PointTriple& triple : fit.triples) {
    const ThreeViewResidual r = MeasureThreeViews(fit.motion, street.camera(), triple);
    if (!r.present) continue;
    EXPECT_LT(std::abs(r.along_pixels), 1e-3);
  }
}

// A point that first stands and then moves along its epipolar line.
TEST(ThreeView, SeesWhatTheEpipolarLineCannot) {
  StreetOptions options;
  options.noise_pixels = 0.2;
  const PointStreet street(options);
  const Fit fit = FitStreet(street, 0, 2, 4);
  ASSERT_TRUE(fit.motion.found);
  int seen = 0, count = 0;
  for (PointTriple triple : fit.triples) {
    const Eigen::Vector2d flow = triple.c - triple.b;
    if (!(flow.norm() > 10.0)) continue;
    triple.c += 4.0 * flow.normalized();  // pixels, 20 times the noise
    const ThreeViewResidual r = MeasureThreeViews(fit.motion, street.camera(), triple);
    if (!r.present) continue;
    ++count;
    seen += r.along_pixels > 3 * r.deviation_pixels ? 1 : 0;
  }
  ASSERT_GT(count, 50);
  EXPECT_GT(seen, 0.9 * count);
}

TEST(ThreeView, DeviationIsThatOfTheNoise) {
  for (const double noise : {0.2, 0.5}) {
    StreetOptions options;
    options.noise_pixels = noise;
    options.static_count = 1500;
    const PointStreet street(options);
    const Fit fit = FitStreet(street, 0, 2, 4);
    ASSERT_TRUE(fit.motion.found);
    std::vector<double> ratios;
    for (const PointTriple& triple : fit.triples) {
      const ThreeViewResidual r = MeasureThreeViews(fit.motion, street.camera(), triple);
      if (r.present) ratios.push_back(std::abs(r.along_pixels) / r.deviation_pixels);
    }
    ASSERT_GT(ratios.size(), 400U);
    std::nth_element(ratios.begin(), ratios.begin() + ratios.size() / 2, ratios.end());
    // The median of |normal| is 0.674; (V2) is first-order, m is a median over 400 and more.
    EXPECT_NEAR(ratios[ratios.size() / 2], 0.674, 0.12) << noise;
  }
}

TEST(ThreeView, AMinorityOfMoversDoesNotMoveTheFit) {
  StreetOptions options;
  options.noise_pixels = 0.2;
  options.mover_count = 150;
  options.mover_travel = {0.2, 0.0, 0.4};
  const PointStreet street(options);
  const Fit fit = FitStreet(street, 0, 2, 4);
  ASSERT_TRUE(fit.motion.found);
  // 450 triples at 0.2 px and flows of about 20 px determine the ratio to 0.2 / 20 / sqrt(450),
  // 5e-4; a fit that gave the movers their say is off by more than 0.02.
  EXPECT_NEAR(fit.motion.speed_ratio, 1.0, 0.01);
}

// One step of two pictures beside one of one.
TEST(ThreeView, AbsentWhereAPictureIsMissing) {
  const PointStreet street(StreetOptions{});
  const Fit before = FitStreet(street, 0, 2, 3), behind = FitStreet(street, 0, 1, 3);
  for (const Fit* fit : {&before, &behind}) {
    EXPECT_FALSE(fit->motion.found);
    EXPECT_FALSE(MeasureThreeViews(fit->motion, street.camera(), fit->triples[0]).present);
  }
  EXPECT_NEAR(before.motion.speed_ratio, 0.5, 1e-3);
  EXPECT_NEAR(behind.motion.speed_ratio, 2.0, 1e-3);
}

TEST(ThreeView, AbsentWithoutPosesOrTriples) {
  const PointStreet street(StreetOptions{});
  const Fit fit = FitStreet(street, 0, 1, 2);
  ASSERT_TRUE(fit.motion.found);
  RelativePose missing;
  const RelativePose pose = Inverse(fit.motion.base_to_first);
  EXPECT_FALSE(FitThreeViews(fit.triples, missing, pose, street.camera(), {}).found);
  EXPECT_FALSE(FitThreeViews(fit.triples, pose, missing, street.camera(), {}).found);
  EXPECT_FALSE(FitThreeViews({}, pose, pose, street.camera(), {}).found);
  const std::vector<PointTriple> broken(
      200, PointTriple{Eigen::Vector2d::Constant(std::nan("")), {1, 1}, {1, 1}});
  EXPECT_FALSE(FitThreeViews(broken, pose, pose, street.camera(), {}).found);
  EXPECT_FALSE(MeasureThreeViews(ThreeViewMotion(), street.camera(), fit.triples[0]).present);
  EXPECT_FALSE(MeasureThreeViews(fit.motion, street.camera(), broken[0]).present);
}

TEST(ThreeView, OptionsAreChecked) {
  EXPECT_TRUE(ThreeViewOptions().Validate().ok());
  EXPECT_FALSE(ThreeViewOptions({.max_triples = 2}).Validate().ok());
  EXPECT_FALSE(ThreeViewOptions({.iterations = 0}).Validate().ok());
}

}  // namespace
}  // namespace egosieve::vision
