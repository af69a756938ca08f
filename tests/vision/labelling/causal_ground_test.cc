// The speed of the ground where there are no pictures ahead, as for live cameras.
#include <gtest/gtest.h>

#include <Eigen/Core>

#include "tests/vision/labelling/street_drive.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/labeller_state.h"
#include "vision/synthetic/camera.h"

namespace egosieve::vision {
namespace {

constexpr int kFirst = 20, kCount = 20;
constexpr double kPicturesPerSecond = 10.0;

TEST(CausalGround, ItsSpeedIsThatOfTheCamera) {
  const Scenario scenario = EditedScenario("street", 3, [](Scene&) {});
  const Pose from = scenario.PoseAt(kFirst), to = scenario.PoseAt(kFirst + kCount - 1);
  FrameLabellerOptions options;
  options.threads = 1;
  options.frame_gap = 0;  // by parallax
  options.focal_ratio = scenario.intrinsics().focal_pixels / scenario.options().width_pixels;
  options.travel.direction = (from.rotation.transpose() * (from.centre - to.centre)).normalized();
  options.travel.concentration = 400.0;
  options.travel.share = 1.0 - TravelPrior::kVehicleTravelsElsewhere;
  const auto labeller = MakeLabeller(options);
  int known = 0;
  for (const DrivePicture& picture : PicturesOf(scenario, kFirst, kCount)) {
    ASSERT_TRUE(labeller->Process(picture.frame).ok());
    const auto k = static_cast<int>(picture.frame.index);
    GroundSpeed speed;
    ASSERT_TRUE(speed.Restore(FromBytes(labeller->state())->ground));
    const double truth = (scenario.PoseAt(k + 1).centre - scenario.PoseAt(k).centre).norm() *
                         kPicturesPerSecond / from.centre.z();
    if (!(speed.Low() > 0.0)) continue;
    ++known;
    // A deviation of at most 0.25 lower; speeds are 0.073 apart. All in the logarithm.
    EXPECT_GT(speed.Low(), 0.7 * truth) << k;
    EXPECT_LT(speed.Low(), 1.1 * truth) << k;
  }
  EXPECT_GE(known, kCount / 2);
}

}  // namespace
}  // namespace egosieve::vision
