#include "vision/labelling/drive_camera.h"

#include <Eigen/Core>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "tests/testing/status.h"
#include "tests/vision/frame/fake_source.h"
#include "tests/vision/labelling/street_drive.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {
namespace {

// The pictures given, of which `damaged` cannot be read; ten a second.
class PictureSource : public FakeSource {
 public:
  explicit PictureSource(const std::vector<DrivePicture>& pictures, std::set<int64_t> damaged = {})
      : FakeSource(static_cast<int64_t>(pictures.size()), std::move(damaged),
                   [pictures](int64_t index) {
                     Frame frame = pictures[index].frame;
                     frame.index = index;
                     frame.time_seconds = 0.1 * static_cast<double>(index);
                     return frame;
                   }) {}
};

TEST(DriveCamera, ATurnTellsTheFocalLength) {
  const Scenario scenario = EditedScenario("turning", 3, [](Scene&) {});
  const std::vector<DrivePicture> pictures = PicturesOf(scenario, 57, 16);
  const double truth = FocalRatioOf(scenario);
  PictureSource source(pictures);
  const DriveCamera camera = *LearnDriveCamera(source, {});
  EXPECT_EQ(camera.pair_count, 8);  // a pair takes two of the 16 pictures
  EXPECT_NEAR(std::log(camera.focal_ratio), std::log(truth), 0.05);
  EXPECT_LT(camera.log_focal_deviation, 0.2);
  // The same again, and with torn pictures nearly so.
  PictureSource again(pictures);
  EXPECT_EQ(LearnDriveCamera(again, {})->focal_ratio, camera.focal_ratio);
  PictureSource torn(pictures, {2, 3, 9});
  EXPECT_NEAR(std::log(LearnDriveCamera(torn, {})->focal_ratio), std::log(truth), 0.1);
}

// While the camera pans and a motorbike drives by, a barrel of 0.08 fits the tracks a little better.
// By the normal distribution there it is likelier by 25 nats, in truth by 6.
TEST(DriveCamera, APanIsNotADistortedLens) {
  const char* folder = std::getenv("EGOSIEVE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
  const auto source = Value(OpenFrameSource(absl::StrCat(folder, "/davis-train/motorbike/frames")));
  DriveCameraOptions options;
  options.pictures.first_frame = 19;
  EXPECT_FALSE(Value(LearnDriveCamera(*source, options)).lens.has_value());
}

// Pairs of a drive, `step` frames from one to the next.
std::vector<DrivePicture> PairsOf(const Scenario& scenario, int pairs, int step) {
  std::vector<DrivePicture> pictures;
  for (int k = 0; k < pairs; ++k) {
    for (DrivePicture& picture : PicturesOf(scenario, 20 + k * step, 2)) {
      pictures.push_back(std::move(picture));
    }
  }
  return pictures;
}

TEST(DriveCamera, AVehicleHardlyTravelsInAnotherDirectionThanItsOwn) {
  PictureSource source(PairsOf(EditedScenario("street", 3, [](Scene&) {}), 12, 5));
  const DriveCamera vehicle = *LearnDriveCamera(source, {});
  EXPECT_TRUE(vehicle.travel.IsOfVehicle());
  EXPECT_LT(1.0 - vehicle.travel.share, 1e-5);
  EXPECT_TRUE(vehicle.windscreen.empty());  // a clean one
}

// The direction from each picture to the next, in the camera's frame, on average.
Eigen::Vector3d TravelOf(const Scenario& scenario, int first, int count) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = first; k + 1 < first + count; ++k) {
    const Pose from = scenario.PoseAt(k), to = scenario.PoseAt(k + 1);
    sum += (from.rotation.transpose() * (to.centre - from.centre)).normalized();
  }
  return sum.normalized();
}

TEST(DriveCamera, FindsTheDirectionOfTravel) {
  for (const uint64_t seed : {3, 4}) {
    const Scenario scenario = EditedScenario("street", seed, [](Scene&) {});
    PictureSource source(PicturesOf(scenario, 20, 24));
    const Eigen::Vector3d found = -LearnDriveCamera(source, {})->travel.direction;
    const Eigen::Vector3d truth = TravelOf(scenario, 20, 24);
    EXPECT_LT(std::atan2(found.cross(truth).norm(), found.dot(truth)) * 180.0 / M_PI, 0.4) << seed;
  }
}

// A reflection on the road, through which it shows.
TEST(DriveCamera, AReflectionIsOnTheWindscreen) {
  const cv::Rect place(120, 150, 160, 60);
  cv::Mat3b reflection(place.height / 6, place.width / 6);
  cv::RNG random(3);
  random.fill(reflection, cv::RNG::UNIFORM, 0, 160);
  cv::resize(reflection, reflection, place.size(), 0.0, 0.0, cv::INTER_CUBIC);
  std::vector<DrivePicture> pictures = PairsOf(EditedScenario("street", 3, [](Scene&) {}), 24, 4);
  for (DrivePicture& picture : pictures) {
    cv::Mat road = picture.frame.image(place);
    cv::addWeighted(road, 0.5, reflection, 1.0, 0.0, road);
  }
  PictureSource source(pictures);
  const cv::Mat1b found = LearnDriveCamera(source, {})->windscreen;
  ASSERT_FALSE(found.empty());
  EXPECT_GT(cv::countNonZero(found(place)), 0.8 * place.area());
  EXPECT_GT(cv::countNonZero(found(place)), 0.6 * cv::countNonZero(found));
}

TEST(DriveCamera, ABonnetIsTheOwnVehicle) {
  std::vector<DrivePicture> pictures = PairsOf(EditedScenario("turning", 3, [](Scene&) {}), 16, 5);
  cv::Mat bonnet = pictures[0].frame.image(cv::Rect(0, 100, 400, 60)).clone();
  for (DrivePicture& picture : pictures) {
    bonnet.copyTo(picture.frame.image(cv::Rect(0, 180, 400, 60)));
  }
  PictureSource source(pictures);
  const DriveCamera camera = *LearnDriveCamera(source, {});
  ASSERT_FALSE(camera.own_vehicle.empty());
  EXPECT_GT(cv::countNonZero(camera.own_vehicle(cv::Rect(0, 188, 400, 52))), 0.9 * 400 * 52);
  EXPECT_LT(cv::countNonZero(camera.own_vehicle(cv::Rect(0, 0, 400, 172))), 0.01 * 400 * 172);

  const DriveCameraOptions without{.finds_own_vehicle = false};
  PictureSource again(pictures);
  EXPECT_TRUE(LearnDriveCamera(again, without)->own_vehicle.empty());
}

// A phone on the dashboard: bonnet and street move in the picture together.
TEST(DriveCamera, ABonnetThatShakesIsTheOwnVehicle) {
  std::vector<DrivePicture> pictures = PairsOf(EditedScenario("street", 3, [](Scene&) {}), 16, 5);
  cv::Mat bonnet = pictures[0].frame.image(cv::Rect(0, 100, 400, 60)).clone();
  for (size_t k = 0; k < pictures.size(); ++k) {
    cv::Mat& image = pictures[k].frame.image;
    bonnet.copyTo(image(cv::Rect(0, 180, 400, 60)));
    const double shake = 3.0 * std::sin(1.7 * static_cast<double>(k / 2));
    const cv::Mat1d shift = (cv::Mat1d(2, 3) << 1, 0, shake, 0, 1, 0.5 * shake);
    cv::Mat shaken;
    cv::warpAffine(image, shaken, shift, image.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    image = shaken;
  }
  PictureSource source(pictures);
  const DriveCamera camera = *LearnDriveCamera(source, {});
  ASSERT_TRUE(camera.travel.IsOfVehicle());
  ASSERT_FALSE(camera.own_vehicle.empty());
  EXPECT_GT(cv::countNonZero(camera.own_vehicle(cv::Rect(0, 188, 400, 52))), 0.8 * 400 * 52);
  EXPECT_LT(cv::countNonZero(camera.own_vehicle(cv::Rect(0, 0, 400, 172))), 0.01 * 400 * 172);
}

TEST(DriveCamera, AVehicleThatIsFollowedIsNotTheOwnVehicle) {
  PictureSource source(PairsOf(EditedScenario("ahead", 4, [](Scene&) {}), 24, 5));
  const cv::Mat1b own = LearnDriveCamera(source, {})->own_vehicle;
  const double share =
      own.empty() ? 0.0 : static_cast<double>(cv::countNonZero(own)) / own.size().area();
  EXPECT_LT(share, 0.001);
}

TEST(DriveCamera, AFocalLengthThatIsKnownIsKept) {
  const DriveCameraOptions options{.focal_ratio = 1.25};
  PictureSource source(PairsOf(EditedScenario("turning", 3, [](Scene&) {}), 2, 5));
  const DriveCamera camera = *LearnDriveCamera(source, options);
  EXPECT_EQ(camera.focal_ratio, 1.25);
  EXPECT_EQ(camera.log_focal_deviation, 0.0);
}

TEST(DriveCamera, NoPairsLeaveThePrior) {
  PictureSource source({});
  const DriveCamera camera = *LearnDriveCamera(source, {});
  EXPECT_EQ(camera.pair_count, 0);
  EXPECT_NEAR(camera.focal_ratio, 0.7, 0.1);
}

}  // namespace
}  // namespace egosieve::vision
