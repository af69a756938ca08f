#include "vision/labelling/pair_motions.h"

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gtest/gtest.h"
#include "tests/vision/labelling/street_drive.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/image/node_grid.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/gap_choice.h"
#include "vision/labelling/lines_along_travel.h"
#include "vision/labelling/mover_memory.h"
#include "vision/labelling/outlook.h"
#include "vision/labelling/track_labeller.h"

namespace egosieve::vision {
namespace {

constexpr int kWidth = 240, kHeight = 160, kShift = 3;

// Picture t of a wall of blurred noise that moves by kShift pixels to the right, but for a square
// of another noise that moves down by `fall` pixels.
std::shared_ptr<ExtractedFrame> PictureOf(int t, int fall) {
  const auto noise = [](int seed, cv::Size size) {
    cv::Mat picture(size, CV_8UC3);
    cv::RNG random(seed);
    random.fill(picture, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(picture, picture, cv::Size(), 2.0);
    cv::normalize(picture, picture, 0, 255, cv::NORM_MINMAX);
    return picture;
  };
  static const cv::Mat wall = noise(1, cv::Size(kWidth + 100, kHeight)),
                       square = noise(2, cv::Size(40, 40));
  auto picture = std::make_shared<ExtractedFrame>();
  picture->frame.index = t;
  wall(cv::Rect(60 - kShift * t, 0, kWidth, kHeight)).copyTo(picture->frame.image);
  square.copyTo(picture->frame.image(cv::Rect(100, 20 + fall * t, 40, 40)));
  cv::cvtColor(picture->frame.image, picture->grey, cv::COLOR_BGR2GRAY);
  return picture;
}

int NodeNear(const GridLinks& links, double x, double y, int stride) {
  return static_cast<int>(NodeAt(x, y, links.nodes.width, stride));
}

TEST(PairMotions, FollowsOverOnePictureAndOverSeveral) {
  FlowGridOptions options;
  PairMotions motions(options, {}, nullptr);
  const auto a = PictureOf(0, 4), b = PictureOf(1, 4), c = PictureOf(2, 4);
  const GridLinks links = *motions.Follow({a.get(), b.get(), c.get()});
  ASSERT_FALSE(links.empty());
  EXPECT_GT(links.followed_share, 0.8);
  const int wall = NodeNear(links, 40, 120, options.stride_pixels);
  const cv::Point2f node = PlaceOfNode(wall, links.nodes.width, options.stride_pixels);
  // Flow is right to a fraction of a pixel on such a texture.
  EXPECT_NEAR(links.near[wall].x - node.x, kShift, 0.3);
  EXPECT_NEAR(links.far[wall].x - node.x, 2 * kShift, 0.5);
  // The right edge leaves the picture.
  const int edge = NodeNear(links, kWidth - 3, 80, options.stride_pixels);
  EXPECT_TRUE(std::isnan(links.far[edge].x));
}

// What is looked ahead to is what is looked back from, computed once.
TEST(PairMotions, BetweenIsTheNearMotion) {
  const Pinhole camera = Pinhole::Of({kWidth, kHeight}, 300);
  const auto a = PictureOf(0, 4), b = PictureOf(1, 4), c = PictureOf(2, 4);
  PairMotions cached({}, {}, nullptr), afresh({}, {}, nullptr);
  const Outlook outlook = *LookAhead(*a, {b, c}, camera, {}, cached);
  ASSERT_NE(outlook.near.frame, nullptr);
  EXPECT_EQ(outlook.near.frame, b.get());
  EXPECT_EQ(outlook.far.frame, c.get());
  const TwoViewMotion known = *cached.Between(*a, *b, camera, {});
  const TwoViewMotion found = *afresh.Between(*a, *b, camera, {});
  EXPECT_EQ(known.rotation, outlook.near.motion.rotation);
  EXPECT_EQ(known.rotation, found.rotation);
  EXPECT_EQ(known.translation, found.translation);
  EXPECT_EQ(known.mean_parallax, found.mean_parallax);
}

TEST(PairMotions, KeepsTheMotionsBetweenEarlierPictures) {
  const Pinhole camera = Pinhole::Of({kWidth, kHeight}, 300);
  const auto a = PictureOf(0, 4), b = PictureOf(1, 4);
  PairMotions motions({}, {}, nullptr);
  EXPECT_EQ(motions.Find(0, 1), nullptr);
  const TwoViewMotion motion = *motions.Between(*a, *b, camera, {});
  ASSERT_TRUE(motions.Between(*a, *PictureOf(2, 4), camera, {}).ok());
  motions.Forget(1, 0);
  EXPECT_EQ(motions.Find(0, 2), nullptr);  // not between earlier pictures
  ASSERT_NE(motions.Find(0, 1), nullptr);
  EXPECT_EQ(motions.Find(0, 1)->rotation, motion.rotation);
  motions.Forget(1, 1);
  EXPECT_EQ(motions.Find(0, 1), nullptr);
}

TEST(PairMotions, TheFixedPatternTellsNothingOfTheMotion) {
  // Three quarters of the picture stay in place, as in a windscreen full of reflections.
  const Pinhole camera = Pinhole::Of({kWidth, kHeight}, 300);
  const auto a = PictureOf(0, 4), b = PictureOf(1, 4), still = PictureOf(5, 4);
  const cv::Rect fixed(0, 0, kWidth, kHeight * 3 / 4);
  cv::Mat1f pattern(kHeight, kWidth, 100.0f);
  still->grey(fixed).convertTo(pattern(fixed), CV_32F);
  for (const auto& picture : {a, b}) still->grey(fixed).copyTo(picture->grey(fixed));
  const auto known = std::make_shared<FixedPattern>(pattern);
  PairMotions with({}, {}, known), without({}, {}, nullptr);
  EXPECT_TRUE(with.FixedIn(*a).Contain({120, 60}));
  EXPECT_FALSE(with.FixedIn(*a).Contain({120, 145}));
  // In front of the camera, places move with the wall by kShift pixels, and not at all else.
  const auto shift_of = [&](PairMotions& motions) {
    const TwoViewMotion motion = *motions.Between(*a, *b, camera, {});
    const double turned = (camera.Matrix() * motion.rotation * camera.Matrix().inverse() *
                           Eigen::Vector3d(120, 140, 1))
                              .hnormalized()
                              .x() -
                          120;
    return turned + (motion.HasParallax() ? motion.parallax_pixels : 0.0);
  };
  EXPECT_NEAR(shift_of(with), kShift, 0.5);
  EXPECT_NEAR(shift_of(without), 0.0, 0.5);
}

// What a hand-held camera, or one that stands, sees in most pictures is no windscreen.
TEST(PatternOf, OnlyVehiclesHaveOne) {
  FrameLabellerOptions options{.fixed_pattern = cv::Mat1b(kHeight, kWidth, uint8_t{100})};
  EXPECT_EQ(PatternOf(options), nullptr);
  options.travel.share = 0.9;
  options.travel.concentration = 400.0;
  EXPECT_NE(PatternOf(options), nullptr);
  options.travel.direction = Eigen::Vector3d::UnitX();
  EXPECT_EQ(PatternOf(options), nullptr);
}

TEST(LookAhead, PassesOverRepeatedPicturesAndStopsAtAnotherSize) {
  const Pinhole camera = Pinhole::Of({kWidth, kHeight}, 300);
  PairMotions motions({}, {}, nullptr);
  const auto a = PictureOf(0, 4), same = PictureOf(0, 4), b = PictureOf(1, 4);
  same->frame.index = 7;
  b->frame.index = 8;
  EXPECT_EQ(LookAhead(*a, {same, b}, camera, {}, motions)->far.frame, b.get());
  const auto other = PictureOf(2, 4);
  other->frame.image = cv::Mat(50, 50, CV_8UC3, cv::Scalar::all(0));
  other->grey = cv::Mat(50, 50, CV_8UC1, cv::Scalar(0));
  EXPECT_TRUE(LookAhead(*a, {other, b}, camera, {}, motions)->empty());
  EXPECT_TRUE(LookAhead(*a, {}, camera, {}, motions)->empty());
}

TEST(LookAhead, AnotherSceneSaysNothing) {
  const Pinhole camera = Pinhole::Of({kWidth, kHeight}, 300);
  PairMotions motions({}, {}, nullptr);
  const auto a = PictureOf(0, 4), cut = PictureOf(1, 4);
  cv::RNG random(9);
  random.fill(cut->grey, cv::RNG::UNIFORM, 0, 256);
  EXPECT_TRUE(LookAhead(*a, {cut}, camera, {}, motions)->empty());
}

TEST(LookAhead, EndsWhereFlowLosesMostPlaces) {
  const Pinhole camera = Pinhole::Of({kWidth, kHeight}, 300);
  PairMotions motions({}, {}, nullptr);
  const auto a = PictureOf(0, 4), b = PictureOf(1, 4), c = PictureOf(2, 4), cut = PictureOf(3, 4);
  cv::RNG random(9);
  random.fill(cut->grey, cv::RNG::UNIFORM, 0, 256);
  const Outlook outlook = *LookAhead(*a, {b, c, cut}, camera, {}, motions);
  EXPECT_EQ(outlook.far.frame, c.get());
  EXPECT_EQ(outlook.near.frame, b.get());
  const Outlook short_one = *LookAhead(*b, {c, cut}, camera, {}, motions);
  EXPECT_EQ(short_one.far.frame, c.get());
  EXPECT_EQ(short_one.near.frame, nullptr);

  TwoViewMotionOptions vehicle;
  vehicle.travel.share = 0.9;
  vehicle.travel.concentration = 400.0;
  ASSERT_TRUE(vehicle.travel.IsOfVehicle());
  PairMotions of_vehicle({}, vehicle, nullptr);
  EXPECT_EQ(of_vehicle.Follow({a.get(), b.get(), c.get(), cut.get()})->last, 3u);
  EXPECT_EQ(motions.Follow({a.get(), b.get(), c.get(), cut.get()})->last, 2u);
}

constexpr int kStride = 5;
const cv::Size kImage(50, 30);  // 10 x 6 nodes, the first at (2, 2)

TrackedPoint At(float x, float y) {
  TrackedPoint point;
  point.evidence.now = {x, y};
  return point;
}

PointEvidence Judged(double probability) { return {.probability = probability, .judged = true}; }

TEST(MoverMemory, GoesWithTheLinks) {
  MoverMemory memory;
  EXPECT_TRUE(memory.CarriedBy({{2, 2, 7, 2}}, kImage).empty());
  EvidenceResult evidence{.points = {Judged(0.9), Judged(0.2), PointEvidence(), Judged(0.8)}};
  evidence.points[3].judged = false;
  memory.Remember({At(2, 2), At(47, 27), At(12, 2), At(17, 2)}, evidence, kImage);
  ASSERT_EQ(memory.nodes().size(), 60u);
  EXPECT_FLOAT_EQ(memory.nodes()[0], 0.9f);
  EXPECT_FLOAT_EQ(memory.nodes()[59], 0.2f);
  EXPECT_EQ(memory.nodes()[2], 0.0f);
  EXPECT_EQ(memory.nodes()[3], 0.0f);

  // The first node moved by a node and a bit, another came to its place.
  const MovedNodes next = memory.CarriedBy({{3.4, 2.9, 12, 7}, {40, 20, 2, 2}}, kImage);
  ASSERT_EQ(next.size(), 60u);
  EXPECT_FLOAT_EQ(next[12], 0.9f);
  EXPECT_EQ(next[0], 0.0f);
  EXPECT_FLOAT_EQ(memory.At(next, {12.0f, 7.0f}, kImage), 0.9f);
  // Pictures of another size have other nodes: nothing outside is read.
  EXPECT_EQ(memory.At(next, {640.0f, 480.0f}, cv::Size(1000, 1000)), 0.0f);
  memory.Forget();
  EXPECT_TRUE(memory.nodes().empty());
}

// Three pixels to the right of a row's last node nothing is read of the next row.
TEST(MoverMemory, TheNearestNodeOfABorderIsInItsRow) {
  const cv::Size wide(52, 30);  // 10 x 6 nodes as well
  MoverMemory memory;
  memory.Remember({At(2, 7), At(47, 27)}, {.points = {Judged(0.9), Judged(0.7)}}, wide);
  EXPECT_EQ(memory.At(memory.nodes(), {50.0f, 2.0f}, wide), 0.0f);
  EXPECT_FLOAT_EQ(memory.At(memory.nodes(), {50.0f, 29.0f}, wide), 0.7f);
}

// Buses come to fill more than half of the picture, while the camera goes on. With a memory of 0
// (`memory` of two_view_motion.h) the bus is the world in many of these frames.
TEST(MoverMemory, ABusThatFillsThePictureMoves) {
  const Scenario scenario = EditedScenario("bus_stop", 1, [](Scene&) {});
  const std::vector<DrivePicture> pictures = PicturesOf(scenario, 55, 45);
  FrameLabellerOptions options{.frame_gap = 1};
  options.focal_ratio = scenario.intrinsics().focal_pixels / scenario.options().width_pixels;
  const std::unique_ptr<FrameLabeller> labeller = MakeLabeller(options);
  LabelCounts counts;
  for (const DrivePicture& picture : pictures) {
    counts.Add(Count(*labeller->Process(picture.frame), picture.movers));
  }
  EXPECT_LT(counts.FalseShare(), 0.02);
  EXPECT_GT(counts.FoundShare(), 0.8);
}

const cv::Size kSize(320, 160);
const Eigen::Vector3d kAhead(0.0, 0.0, 1.0);

Pinhole Camera() { return Pinhole::Of(kSize, 200.0); }

// A bright strip, blurred as a camera does.
cv::Mat StripFrom(cv::Point2d from, cv::Point2d to) {
  cv::Mat grey(kSize, CV_8UC1, cv::Scalar(80));
  cv::line(grey, from, to, cv::Scalar(220), 6, cv::LINE_AA);
  cv::GaussianBlur(grey, grey, {}, 1.0);
  return grey;
}

cv::Point2f Between(cv::Point2d from, cv::Point2d to) { return (from + to) * 0.5; }

TEST(LinesAlongTravel, ALaneLineIsOneAndAStopLineIsNot) {
  const Pinhole camera = Camera();
  const cv::Point2d vanishing(camera.centre_x, camera.centre_y);
  const cv::Point2d near(60.0, 150.0), far = vanishing + (near - vanishing) * 0.2;
  const LinesAlongTravel lane(StripFrom(near, far), camera, kAhead);
  EXPECT_TRUE(lane.Contain(Between(near, far)));
  EXPECT_FALSE(lane.Contain({250.0F, 120.0F})) << "blank";

  const cv::Point2d left(60.0, 120.0), right(160.0, 120.0);
  EXPECT_FALSE(
      LinesAlongTravel(StripFrom(left, right), camera, kAhead).Contain(Between(left, right)));
}

TEST(LinesAlongTravel, TheDirectionOfTravelCounts) {
  const Pinhole camera = Camera();
  // Towards a point 100 pixels to the right of the middle.
  const Eigen::Vector3d travel = Eigen::Vector3d(0.5, 0.0, 1.0).normalized();
  const cv::Point2d vanishing(camera.centre_x + 100.0, camera.centre_y);
  const cv::Point2d near(60.0, 150.0), far = vanishing + (near - vanishing) * 0.2;
  const cv::Mat grey = StripFrom(near, far);
  EXPECT_TRUE(LinesAlongTravel(grey, camera, travel).Contain(Between(near, far)));
  EXPECT_FALSE(LinesAlongTravel(grey, camera, kAhead).Contain(Between(near, far)));
}

TEST(LinesAlongTravel, NoneAboveTheHorizon) {
  const Pinhole camera = Camera();
  const cv::Point2d vanishing(camera.centre_x, camera.centre_y);
  const cv::Point2d near(60.0, 10.0), far = vanishing + (near - vanishing) * 0.2;
  EXPECT_FALSE(LinesAlongTravel(StripFrom(near, far), camera, kAhead).Contain(Between(near, far)));
}

// The camera moves ahead by a tenth of its height above the ground.
TEST(SeemsNoNearerThanGround, TellsTheGroundFromWhatStandsOnIt) {
  const Pinhole camera = Camera();
  TwoViewMotion motion;
  motion.found = true;
  motion.translation = -kAhead;
  motion.mean_parallax = 0.05;
  motion.noise = 0.5 / camera.focal_pixels;
  motion.static_share = 0.9;
  motion.moving_scale = 10.0 / camera.focal_pixels;
  motion.noise_pixels = 0.5;
  const auto seen = [&](double share_of_ground) {
    const cv::Point2f now(100.0F, 140.0F);
    const Eigen::Vector3d ray = camera.Ray(now.x, now.y);
    // The ground is one height below the camera; X = ray / r in heights.
    const double inverse_depth = share_of_ground * ray(1);
    const Eigen::Vector3d point = ray / inverse_depth + 0.1 * motion.translation;
    const Eigen::Vector2d there = camera.Project(point);
    return SeemsNoNearerThanGround(motion, camera, now,
                                   {static_cast<float>(there(0)), static_cast<float>(there(1))});
  };
  EXPECT_FALSE(seen(0.5)) << "the ground is not known";
  motion.ground_heights = 0.1;
  EXPECT_TRUE(seen(0.1));
  EXPECT_TRUE(seen(1.0));
  EXPECT_FALSE(seen(1.4));
  EXPECT_FALSE(seen(3.0));
}

constexpr int kLongest = 5;

// What the gap settles at where a picture brings so much parallax.
int SettledGap(double pixels_a_picture, GapState state = {}) {
  for (int t = 0; t < 60; ++t) {
    ObserveParallax(pixels_a_picture * state.gap, state.gap, kLongest, state);
  }
  return state.gap;
}

// Three pixels of parallax are wanted.
TEST(GapChoice, LessParallaxMakesItLonger) {
  EXPECT_EQ(SettledGap(4.0), 1);  // driving
  EXPECT_EQ(SettledGap(2.6), 1);
  EXPECT_EQ(SettledGap(1.8), 2);
  EXPECT_EQ(SettledGap(1.1), 3);
  EXPECT_EQ(SettledGap(0.78), 4);        // walking pace, in small pictures
  EXPECT_EQ(SettledGap(0.2), kLongest);  // in the hand
  EXPECT_EQ(SettledGap(0.0), kLongest);  // standing
}

TEST(GapChoice, StaysWhereItIsNearABorder) {
  GapState state;
  for (int t = 0; t < 60; ++t) ObserveParallax(1.5 * state.gap, state.gap, kLongest, state);
  ASSERT_EQ(state.gap, 2);
  // 3 / p is 1.9 and 2.2 in turn.
  for (int t = 0; t < 20; ++t) {
    ObserveParallax((t % 2 == 0 ? 1.58 : 1.36) * state.gap, state.gap, kLongest, state);
    EXPECT_EQ(state.gap, 2) << t;
  }
  EXPECT_EQ(SettledGap(6.0, state), 1);
}

TEST(GapChoice, NonsenseChangesNothing) {
  GapState state;
  ObserveParallax(3.0, 3, kLongest, state);
  const GapState before = state;
  ObserveParallax(std::nan(""), 1, kLongest, state);
  ObserveParallax(INFINITY, 1, kLongest, state);
  ObserveParallax(-1.0, 1, kLongest, state);
  ObserveParallax(1.0, 0, kLongest, state);
  EXPECT_EQ(state.gap, before.gap);
  EXPECT_EQ(state.log_parallax, before.log_parallax);
}

}  // namespace
}  // namespace egosieve::vision
