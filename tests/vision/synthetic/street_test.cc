#include "vision/synthetic/street.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/core.hpp>
#include <set>

#include "tests/testing/status.h"

namespace egosieve::vision {
namespace {

using ::testing::HasSubstr;

ScenarioOptions Small() { return {.width_pixels = 160, .height_pixels = 90}; }

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int y = 0; y < a.rows; ++y) {
    if (std::memcmp(a.ptr(y), b.ptr(y), a.cols * a.elemSize()) != 0) return false;
  }
  return true;
}

class EveryScenarioTest : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryScenarioTest, TruthIsConsistent) {
  const Scenario scenario = Value(MakeScenario(GetParam(), 5, Small()));
  int moving_pixels = 0;
  for (const int t : {0, 45, 90, 149}) {
    const SyntheticFrame frame = *scenario.Render(t);
    ASSERT_EQ(frame.image.type(), CV_8UC3);
    ASSERT_EQ(frame.image.size(), cv::Size(160, 90));
    std::map<int, const ObjectState*> objects;
    for (const ObjectState& object : frame.objects) objects[object.id] = &object;
    std::map<int, int> areas;
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 160; ++x) {
        const int id = frame.ids.at<uint16_t>(y, x);
        const bool moving = frame.mask.at<uint8_t>(y, x) == 255;
        EXPECT_GT(frame.depth.at<double>(y, x), 0.0);
        EXPECT_EQ(moving, id != 0 && objects.at(id)->moving);
        moving_pixels += moving;
        if (id != 0) ++areas[id];
      }
    }
    for (const auto& [id, object] : objects) {
      EXPECT_EQ(object->area_pixels, areas[id]);
      EXPECT_EQ(object->moving, object->velocity.norm() > 0.05);
      EXPECT_EQ(object->moving, object->relation != Relation::kStanding);
      EXPECT_GT(object->distance_metres, 0.5);  // nothing drives through the camera
    }
    // Neither black nor white, and not of one colour.
    cv::Scalar mean, deviation;
    cv::meanStdDev(frame.image, mean, deviation);
    EXPECT_GT(mean[1], 25);
    EXPECT_LT(mean[1], 200);
    EXPECT_GT(deviation[1], 15);
  }
  EXPECT_EQ(moving_pixels == 0, GetParam() == "empty");
}

TEST_P(EveryScenarioTest, FramesDependOnNeitherThreadsNorPredecessors) {
  ScenarioOptions options = Small();
  const Scenario two = *MakeScenario(GetParam(), 6, options);
  ASSERT_TRUE(two.Render(0).ok());
  const SyntheticFrame after_another = *two.Render(31);
  options.threads = 1;
  const SyntheticFrame alone = *MakeScenario(GetParam(), 6, options)->Render(31);
  EXPECT_TRUE(SameBytes(alone.image, after_another.image));
  EXPECT_TRUE(SameBytes(alone.ids, after_another.ids));
  EXPECT_TRUE(SameBytes(alone.depth, after_another.depth));
  const SyntheticFrame other_seed = *MakeScenario(GetParam(), 7, options)->Render(31);
  EXPECT_FALSE(SameBytes(alone.image, other_seed.image));
}

INSTANTIATE_TEST_SUITE_P(Names, EveryScenarioTest, ::testing::ValuesIn(ScenarioNames()),
                         [](const auto& info) { return info.param; });

// The relations of all movers that a drive shows with at least `area` pixels.
std::multiset<Relation> MovingRelations(const char* name, int area) {
  std::multiset<Relation> relations;
  const Scenario scenario = *MakeScenario(name, 1, Small());
  for (int t = 0; t < 150; t += 10) {
    const SyntheticFrame frame = *scenario.Render(t);
    for (const ObjectState& object : frame.objects) {
      if (object.moving && object.area_pixels >= area) relations.insert(object.relation);
    }
  }
  return relations;
}

TEST(StreetTest, ScenariosShowWhatTheyAreNamedAfter) {
  EXPECT_GE(MovingRelations("ahead", 20).count(Relation::kAhead), 10u);
  EXPECT_GE(MovingRelations("oncoming", 20).count(Relation::kOncoming), 10u);
  EXPECT_GE(MovingRelations("crossing", 20).count(Relation::kCrossing), 10u);
  EXPECT_GE(MovingRelations("overtaking", 20).count(Relation::kAhead), 10u);
  EXPECT_GE(MovingRelations("pedestrians", 8).size(), 30u);
}

TEST(StreetTest, ACarThatStopsLeavesTheMaskAndComesBack) {
  // The car ahead brakes to a stop and goes on; the camera waits behind it.
  const Scenario scenario = *MakeScenario("stop_and_go", 1, Small());
  std::map<int, std::set<bool>> seen;
  for (int t = 0; t < 150; t += 5) {
    const SyntheticFrame frame = *scenario.Render(t);
    for (const ObjectState& object : frame.objects) {
      if (object.area_pixels < 40) continue;
      seen[object.id].insert(object.moving);
      const cv::Mat pixels = frame.ids == object.id;
      EXPECT_EQ(cv::countNonZero(pixels & frame.mask), object.moving ? object.area_pixels : 0);
    }
  }
  EXPECT_TRUE(
      std::any_of(seen.begin(), seen.end(), [](const auto& s) { return s.second.size() == 2; }));
}

TEST(StreetTest, TheCameraStopsInStopAndGoAndTurnsInTurning) {
  const Scenario stop = *MakeScenario("stop_and_go", 1, Small());
  EXPECT_LT((stop.PoseAt(50).centre - stop.PoseAt(55).centre).norm(), 1e-9);
  EXPECT_GT((stop.PoseAt(0).centre - stop.PoseAt(5).centre).norm(), 1.0);
  const Scenario turn = *MakeScenario("turning", 1, Small());
  EXPECT_LT(turn.PoseAt(0).rotation.col(2).dot(turn.PoseAt(149).rotation.col(2)), 0.1);
  const Scenario pan = *MakeScenario("panning", 1, Small());
  EXPECT_LT((pan.PoseAt(0).centre - pan.PoseAt(149).centre).norm(), 1e-9);
}

TEST(StreetTest, TheSameSecondsAtAnotherRateAreTheSameDrive) {
  ScenarioOptions slow = Small(), fast = Small();
  slow.frames = 30;
  fast.frames = 90;
  fast.frames_per_second = 30.0;
  for (const char* name : {"street", "walk", "cyclists"}) {
    const Scenario at_10 = *MakeScenario(name, 3, slow), at_30 = *MakeScenario(name, 3, fast);
    const SyntheticFrame one = *at_10.Render(20), same = *at_30.Render(60);
    EXPECT_EQ(one.seconds, same.seconds);
    EXPECT_TRUE(SameBytes(one.ids, same.ids)) << name;
    EXPECT_TRUE(SameBytes(one.depth, same.depth)) << name;
  }
}

// A round later the camera is where it was, but for the springs of the car; what moves is not.
TEST(StreetTest, RoundsPassTheSamePlacesAmongOtherTraffic) {
  ScenarioOptions options = Small();
  options.frames = 1900;
  const Scenario scenario = *MakeScenario("rounds", 1, options);
  int moving = 0;
  for (const int t : {30, 120, 280, 400}) {
    const Pose first = scenario.PoseAt(t);
    const SyntheticFrame before = *scenario.Render(t);
    for (const int later : {t + 450, t + 3 * 450}) {
      const Pose again = scenario.PoseAt(later);
      EXPECT_LT((again.centre - first.centre).norm(), 0.1);
      EXPECT_GT(again.rotation.col(2).dot(first.rotation.col(2)), std::cos(0.05));
      const SyntheticFrame after = *scenario.Render(later);
      EXPECT_FALSE(SameBytes(before.mask, after.mask));
      moving += cv::countNonZero(after.mask == 255) > 0;
    }
  }
  EXPECT_GE(moving, 6);
}

TEST(StreetTest, TheDashcamSeesTheSameStreetBehindItsOwnVehicle) {
  ScenarioOptions options = Small();
  options.noise = false;
  const SyntheticFrame street = *MakeScenario("street", 4, options)->Render(40);
  const SyntheticFrame dashcam = *MakeScenario("dashcam", 4, options)->Render(40);
  EXPECT_TRUE(street.own_vehicle.empty());
  const cv::Mat own = dashcam.own_vehicle;
  EXPECT_GT(cv::countNonZero(own), 0.15 * own.total());
  EXPECT_LT(cv::countNonZero(own), 0.4 * own.total());
  EXPECT_EQ(cv::countNonZero((dashcam.mask == 128) != own), 0);
  EXPECT_EQ(cv::countNonZero((dashcam.ids != 0) & own), 0);
  EXPECT_EQ(cv::countNonZero((dashcam.mask != street.mask) & ~own), 0);
  // The windscreen's reflections are seen beside what the vehicle hides, and stay where they are.
  cv::Mat change;
  cv::absdiff(street.image, dashcam.image, change);
  EXPECT_GT(cv::mean(change, ~own)[1], 2.0);
  const SyntheticFrame later = *MakeScenario("dashcam", 4, options)->Render(60);
  EXPECT_TRUE(SameBytes(own, later.own_vehicle));
}

TEST(StreetTest, AWanderingExposureChangesTheLightAlone) {
  ScenarioOptions options = Small();
  const Scenario steady = *MakeScenario("street", 4, options);
  options.exposure_swing = 0.5;
  const Scenario wandering = *MakeScenario("street", 4, options);
  double least = 1e9, most = 0.0;
  for (const int t : {5, 20, 35, 50, 65}) {
    const SyntheticFrame a = *steady.Render(t), b = *wandering.Render(t);
    EXPECT_TRUE(SameBytes(a.ids, b.ids));
    const double ratio = cv::mean(b.image)[1] / cv::mean(a.image)[1];
    least = std::min(least, ratio);
    most = std::max(most, ratio);
  }
  EXPECT_GT(most / least, 1.1);
}

TEST(StreetTest, CyclistsGoAheadInTheCamerasDirection) {
  const Scenario scenario = *MakeScenario("cyclists", 1, Small());
  int cyclists = 0, people = 0;
  for (int t = 0; t < 150; t += 10) {
    const SyntheticFrame frame = *scenario.Render(t);
    for (const ObjectState& object : frame.objects) {
      if (!object.moving || object.area_pixels < 8) continue;
      EXPECT_EQ(object.relation, Relation::kAhead);
      cyclists += object.object_class == ObjectClass::kCyclist;
      people += object.object_class == ObjectClass::kPedestrian;
    }
  }
  EXPECT_GE(cyclists, 20);
  EXPECT_GE(people, 10);
}

TEST(StreetTest, AWalkPassesCloseToTrunksAndRailings) {
  const Scenario scenario = *MakeScenario("walk", 1, Small());
  int near_pixels = 0;
  for (int t = 0; t < 150; t += 15) {
    const SyntheticFrame frame = *scenario.Render(t);
    for (int y = 0; y < 45; ++y) {  // above the ground
      for (int x = 0; x < 160; ++x) {
        near_pixels += frame.ids.at<uint16_t>(y, x) == 0 && frame.depth.at<double>(y, x) < 3.0;
      }
    }
  }
  EXPECT_GT(near_pixels, 10 * 160 * 45 / 50);  // 2 percent
}

TEST(StreetTest, WrongRequestsAreRefusedInWords) {
  EXPECT_EQ(MakeScenario("motorway", 1).status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(MakeScenario("motorway", 1).status().message()), HasSubstr("overtaking"));
  ScenarioOptions options = Small();
  options.frames_per_second = std::nan("");
  EXPECT_THAT(MakeScenario("street", 1, options), IsInvalid());
  options = Small();
  options.radial = -0.4;  // turns back before the corners
  EXPECT_THAT(std::string(MakeScenario("street", 1, options).status().message()),
              HasSubstr("radial = -0.4"));
  const Scenario scenario = *MakeScenario("street", 1, Small());
  EXPECT_EQ(scenario.Render(150).status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(scenario.Render(-1).status().code(), absl::StatusCode::kOutOfRange);
}

}  // namespace
}  // namespace egosieve::vision
