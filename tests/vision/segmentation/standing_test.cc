// Five minutes at ten frames a second before a red light: every frame is answered, and the model
// that the drive goes on with is as good as if it had never stood.
#include <iostream>

#include "gtest/gtest.h"
#include "tests/vision/segmentation/disturbed_drive.h"

namespace egosieve::vision {
namespace {

constexpr int kFiveMinutes = 3000;
constexpr double kAllowedLoss = 0.02;

class FiveMinutes : public testing::TestWithParam<DriveProfile> {
 protected:
  void ExpectSound(const Disturbance& standing) {
    const double undisturbed = UndisturbedAuc(GetParam());
    const double disturbed = AucOfTheEnd(GetParam(), standing);
    std::cout << standing.name << ": AUC " << disturbed << ", undisturbed " << undisturbed << "\n";
    EXPECT_GE(disturbed, undisturbed - kAllowedLoss);
  }
};

TEST_P(FiveMinutes, OfStandingStill) {
  ExpectSound({"standing still", StandingStill, kFiveMinutes});
}

TEST_P(FiveMinutes, OfStandingAmongMovers) {
  ExpectSound({"standing among movers", StandingAmongMovers, kFiveMinutes});
}

INSTANTIATE_TEST_SUITE_P(Profiles, FiveMinutes,
                         testing::Values(DriveProfile::kDefault, DriveProfile::kFast),
                         [](const auto& profile) {
                           return profile.param == DriveProfile::kFast ? "Fast" : "Default";
                         });

}  // namespace
}  // namespace egosieve::vision
