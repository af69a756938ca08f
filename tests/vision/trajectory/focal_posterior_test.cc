#include "vision/trajectory/focal_posterior.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/vision/evidence/point_street.h"

namespace egosieve::vision {
namespace {

FocalPosterior Learn(const StreetOptions& options, int pairs) {
  const PointStreet street(options);
  FocalPosterior posterior;
  for (int t = 0; t < pairs; ++t) {
    const Pinhole camera = Pinhole::Of(
        options.size, posterior.Estimate() * std::max(options.size.width, options.size.height));
    const std::vector<PointPair> links = street.Pairs(t, t + 1);
    posterior.Observe(links, camera, EstimateTwoViewMotion(links, camera, {}), options.size);
  }
  return posterior;
}

TEST(FocalPosterior, TurningTellsTheFocalLength) {
  for (const double focal : {560.0, 1400.0}) {
    StreetOptions options;
    options.size = {800, 600};
    options.focal_pixels = focal;
    options.yaw = 0.04;
    options.pitch = 0.01;
    options.noise_pixels = 0.2;
    options.travel = {0.0, 0.0, 0.05};
    const FocalPosterior posterior = Learn(options, 12);
    // Candidates are 36 % apart.
    EXPECT_NEAR(std::log(posterior.Estimate()), std::log(focal / 800), 0.15) << focal;
    EXPECT_LT(posterior.LogDeviation(), 0.25);
  }
}

TEST(FocalPosterior, NothingSeenLeavesThePrior) {
  FocalPosterior posterior;
  const double before = posterior.Estimate();
  // The mean over the candidates, not the prior's centre, which lies off the middle of them.
  EXPECT_NEAR(before, 0.7, 0.05);
  posterior.Observe({}, Pinhole::Of({640, 480}, 0), TwoViewMotion(), {640, 480});
  EXPECT_EQ(posterior.Estimate(), before);
}

}  // namespace
}  // namespace egosieve::vision
