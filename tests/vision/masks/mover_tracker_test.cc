#include "vision/masks/mover_tracker.h"

#include <opencv2/imgproc.hpp>
#include <vector>

#include "gtest/gtest.h"
#include "tests/testing/status.h"
#include "vision/masks/mask_image.h"
#include "vision/masks/mover_links.h"
#include "vision/masks/pixel_assignment.h"

namespace egosieve::vision {
namespace {

const cv::Size kSize(160, 80);

struct Body {
  cv::Rect box;   // at time 0
  int speed = 0;  // pixels a frame, to the right
  cv::Vec3b colour;
  int gone_from = 99, back_from = 99;  // frames in which it is hidden
};

struct Scene {
  cv::Mat3b image;
  cv::Mat1b mask;
  FlowPair flow;
};

cv::Rect BoxAt(const Body& body, int t) { return body.box + cv::Point(body.speed * t, 0); }

// Exact flow; later bodies are before earlier ones.
Scene SceneAt(const std::vector<Body>& bodies, int t) {
  Scene scene{cv::Mat3b(kSize, cv::Vec3b(90, 90, 90)), cv::Mat1b::zeros(kSize), {}};
  cv::Mat2f forward = cv::Mat2f::zeros(kSize), backward = cv::Mat2f::zeros(kSize);
  const cv::Rect frame({}, kSize);
  for (const Body& body : bodies) {
    const float speed = static_cast<float>(body.speed);
    forward(BoxAt(body, t - 1) & frame) = cv::Vec2f(speed, 0.0f);
    if (t >= body.gone_from && t < body.back_from) continue;
    const cv::Rect box = BoxAt(body, t) & frame;
    scene.image(box) = body.colour;
    scene.mask(box) = 255;
    backward(box) = cv::Vec2f(-speed, 0.0f);
  }
  scene.flow = {forward, backward};
  return scene;
}

// Frames 0 to `last`.
std::vector<TrackedFrame> FramesOf(const std::vector<Body>& bodies, int last) {
  std::vector<TrackedFrame> frames;
  for (int t = 0; t <= last; ++t) {
    const Scene scene = SceneAt(bodies, t);
    const FlowPair flow = t > 0 ? scene.flow : FlowPair();
    frames.push_back({0.1 * t, scene.image, flow, ReturnErrorsOf(flow)});
  }
  return frames;
}

cv::Mat1w Track(MoverTracker& tracker, const std::vector<Body>& bodies, int t, int ahead = 0) {
  return tracker.Add(FramesOf(bodies, t + ahead), t, SceneAt(bodies, t).mask);
}

const cv::Vec3b kRed(30, 30, 220), kBlue(220, 60, 30);

TEST(MoverTracker, MoversThatTouchKeepTheirNumbers) {
  const std::vector<Body> bodies = {{{10, 20, 30, 30}, 4, kRed}, {{120, 25, 30, 30}, -4, kBlue}};
  MoverTracker tracker;
  std::vector<SightedFrame> sighted;
  std::vector<cv::Mat1w> numbers;
  for (int t = 0; t <= 20; ++t) {
    numbers.push_back(Track(tracker, bodies, t));
    sighted.push_back(SightingsOf(FramesOf(bodies, t), t, numbers.back(), true));
  }
  const uint16_t red = numbers[0](30, 20), blue = numbers[0](30, 130);
  EXPECT_NE(red, blue);
  // At t = 12 they overlap by 16 pixels; what is seen of each is still its own.
  EXPECT_EQ(numbers[12](30, 62), red);
  EXPECT_EQ(numbers[12](30, 98), blue);
  // At t = 14 hardly any of red is seen, and after it the tracker calls red another.
  MoverLinks links;
  const auto movers = links.Add(sighted);
  EXPECT_EQ(movers[20].at(numbers[20](30, 110)), movers[0].at(red));
  EXPECT_EQ(movers[20].at(numbers[20](40, 50)), movers[0].at(blue));
}

TEST(MoverTracker, AMoverThatAppearsBesideAnotherIsNew) {
  const std::vector<Body> bodies = {{{60, 20, 30, 30}, -3, kRed}, {{90, 20, 30, 30}, 3, kBlue}};
  std::vector<Body> second_hidden = bodies;
  second_hidden[1].gone_from = 0;
  MoverTracker tracker;
  cv::Mat1w numbers = Track(tracker, second_hidden, 0);
  const uint16_t red = numbers(30, 70);
  // Nothing is between them in frame 1: the red one's region takes in the blue one's.
  Scene scene = SceneAt(bodies, 1);
  scene.mask(cv::Rect(80, 25, 20, 10)) = 255;
  std::vector<TrackedFrame> frames = FramesOf(second_hidden, 0);
  frames.push_back({0.1, scene.image, scene.flow, ReturnErrorsOf(scene.flow)});
  numbers = tracker.Add(frames, 1, scene.mask);
  EXPECT_EQ(numbers(30, 70), red);
  EXPECT_NE(numbers(30, 110), red);
  EXPECT_NE(numbers(30, 110), 0);
}

TEST(MoverTracker, MoversThatPartGetNumbersOfTheirOwn) {
  const std::vector<Body> bodies = {{{60, 20, 30, 30}, -3, kRed}, {{90, 20, 30, 30}, 3, kBlue}};
  MoverTracker tracker;
  cv::Mat1w numbers;
  for (int t = 0; t < 8; ++t) numbers = Track(tracker, bodies, t);
  EXPECT_NE(numbers(30, 50), 0);
  EXPECT_NE(numbers(30, 130), 0);
  EXPECT_NE(numbers(30, 50), numbers(30, 130));
}

TEST(MoverTracker, SpecksAreNoMovers) {
  MoverTracker tracker;
  cv::Mat1b mask = cv::Mat1b::zeros(kSize);
  mask(cv::Rect(5, 5, 4, 4)) = 255;
  const std::vector<TrackedFrame> frames = {{0.0, cv::Mat3b(kSize, cv::Vec3b()), {}, {}}};
  EXPECT_EQ(cv::countNonZero(tracker.Add(frames, 0, mask)), 0);
}

TEST(MoverTracker, GoesOnAfterRestoreToTheLastBit) {
  const std::vector<Body> bodies = {{{10, 20, 30, 30}, 4, kRed, 4, 7},
                                    {{120, 25, 30, 30}, -4, kBlue}};
  MoverTracker whole;
  for (int t = 0; t < 5; ++t) Track(whole, bodies, t);
  MoverTracker restored = Value(MoverTracker::Restore(whole.ToText()));
  for (int t = 5; t < 14; ++t) {
    const cv::Mat1w expected = Track(whole, bodies, t), found = Track(restored, bodies, t);
    EXPECT_EQ(cv::countNonZero(expected != found), 0) << t;
  }
  EXPECT_EQ(whole.ToText(), restored.ToText());
  EXPECT_FALSE(MoverTracker::Restore("{}").ok());
  EXPECT_FALSE(MoverTracker::Restore("not json").ok());
}

TEST(MoverTracker, RemembersTheCentre) {
  MoverTracker tracker;
  Track(tracker, {{{10, 20, 30, 40}, 0, kRed}}, 0);
  // Columns 10 to 39, rows 20 to 59.
  EXPECT_THAT(tracker.ToText(), testing::HasSubstr("\"centre\":[24.5,39.5]"));
}

TEST(MoverTracker, WhatPartsLaterIsTwoFromTheFirstFrameOn) {
  // Red stands before blue, and they part by 6 pixels a frame.
  const std::vector<Body> bodies = {{{60, 20, 60, 40}, 3, kBlue}, {{80, 30, 16, 30}, -3, kRed}};
  MoverTracker tracker;
  const cv::Mat1w numbers = Track(tracker, bodies, 0, 5);
  EXPECT_NE(numbers(45, 88), 0);
  EXPECT_NE(numbers(45, 70), 0);
  EXPECT_NE(numbers(45, 88), numbers(45, 70));
  EXPECT_EQ(numbers(45, 70), numbers(45, 112));
}

TEST(MaskOf, FillsHolesAndKeepsUnsurePixelsStatic) {
  cv::Mat1f p(200, 200, 0.5f);  // the prior: likely everywhere, sure nowhere
  EXPECT_EQ(cv::countNonZero(MaskOf(p, {0.5, 0.7}, {})), 0);
  p.setTo(0.2f);
  p(cv::Rect(50, 50, 60, 60)) = 0.9f;
  p(cv::Rect(70, 70, 4, 4)) = 0.1f;
  p(cv::Rect(150, 150, 20, 20)) = 0.6f;
  cv::Mat1b excluded = cv::Mat1b::zeros(p.size());
  excluded(cv::Rect(100, 50, 10, 60)) = 255;
  const cv::Mat1b mask = MaskOf(p, {0.5, 0.7}, excluded);
  EXPECT_EQ(cv::countNonZero(mask), 50 * 60 - 4);  // the median rounds corners off
  EXPECT_EQ(mask(72, 72), 255);
  EXPECT_EQ(mask(60, 105), 0);
}

TEST(NumberPixels, ReachesTheMasksRimAndNoFurther) {
  cv::Mat1w small = cv::Mat1w::zeros(50, 50);
  small(cv::Rect(10, 10, 10, 10)) = 7;
  cv::Mat1b mask = cv::Mat1b::zeros(100, 100);
  mask(cv::Rect(18, 18, 24, 24)) = 255;
  mask(cv::Rect(70, 70, 3, 3)) = 255;
  const cv::Mat1w numbers = NumberPixels(small, mask);
  EXPECT_EQ(numbers(18, 18), 7);
  EXPECT_EQ(numbers(41, 41), 7);
  EXPECT_EQ(cv::countNonZero(numbers), 24 * 24);
  EXPECT_EQ(cv::countNonZero(mask), 24 * 24);
}

const cv::Size kPicture(120, 60);
const cv::Rect kBack(20, 15, 70, 30), kFront(50, 20, 14, 30);
constexpr int kBackStep = 6, kFrontStep = -6;

cv::Mat3b Texture(uint64_t seed) {
  cv::Mat3b image(kPicture);
  cv::RNG random(seed);
  random.fill(image, cv::RNG::UNIFORM, 60, 180);
  cv::GaussianBlur(image, image, {}, 1.2);
  return image;
}

// Two textured bodies, the front one before the other, after t steps; what is whose in `owner`.
cv::Mat3b PictureAt(int t, cv::Mat1w* owner) {
  static const cv::Mat3b back = Texture(1), front = Texture(2);
  cv::Mat3b image(kPicture, cv::Vec3b(30, 30, 30));
  *owner = cv::Mat1w::zeros(kPicture);
  back(kBack).copyTo(image(kBack + cv::Point(kBackStep * t, 0)));
  (*owner)(kBack + cv::Point(kBackStep * t, 0)) = uint16_t{1};
  front(kFront).copyTo(image(kFront + cv::Point(kFrontStep * t, 0)));
  (*owner)(kFront + cv::Point(kFrontStep * t, 0)) = uint16_t{2};
  return image;
}

// Flow that says nothing: it does not return.
FlowPair NoFlow() {
  return {cv::Mat(kPicture, CV_32FC2, cv::Scalar(9.0, 9.0)),
          cv::Mat(kPicture, CV_32FC2, cv::Scalar(9.0, 9.0))};
}

KnownMover Moving(uint16_t number, int step, const ColourShares& colours) {
  return {number, {{}, {static_cast<double>(step), 0.0}, cv::Matx22d::zeros()}, &colours};
}

double ShareRight(const cv::Mat1w& numbers, const cv::Mat1w& truth) {
  return static_cast<double>(cv::countNonZero((numbers == truth) & (truth != 0))) /
         cv::countNonZero(truth);
}

TEST(AssignPixels, PicturesTellWhoseAPixelIsWhereFlowSaysNothing) {
  cv::Mat1w last, truth, later;
  AssignmentPictures pictures{
      .before = {.image = PictureAt(0, &last)},
      .now = {0.0, PictureAt(1, &truth), NoFlow(), ReturnErrorsOf(NoFlow())},
      .mask = truth != 0};
  const ColourShares colours = {};
  const std::vector<KnownMover> movers = {Moving(1, kBackStep, colours),
                                          Moving(2, kFrontStep, colours)};
  // 12 columns appear from behind the front body: the picture before does not show them, the one
  // after does. They are 12 x 25 of the 2,170 pixels.
  const double without = ShareRight(AssignPixels(pictures, last, movers), truth);
  EXPECT_GT(without, 0.8);
  pictures.after = {0.0, PictureAt(2, &later), NoFlow(), ReturnErrorsOf(NoFlow())};
  const double with = ShareRight(AssignPixels(pictures, last, movers), truth);
  EXPECT_GT(with, 0.95);
  EXPECT_GT(with, without);
}

TEST(AssignPixels, LeavesPixelsThatNoMoverExplains) {
  cv::Mat1w last, truth;
  AssignmentPictures pictures{.before = {.image = PictureAt(0, &last)},
                              .now = {.image = PictureAt(1, &truth).clone()}};
  // Something white with flow of its own appears 20 pixels beside the back body.
  const cv::Rect new_body(112, 20, 8, 20);
  pictures.now.image(new_body) = cv::Vec3b(255, 255, 255);
  pictures.now.flow = {cv::Mat(kPicture, CV_32FC2, cv::Scalar(kBackStep, 0.0)),
                       cv::Mat(kPicture, CV_32FC2, cv::Scalar(-kBackStep, 0.0))};
  pictures.now.flow.backward(new_body).setTo(cv::Scalar(8.0, 0.0));
  pictures.now.flow.forward.colRange(112, 120).setTo(cv::Scalar(-8.0, 0.0));
  pictures.now.errors = ReturnErrorsOf(pictures.now.flow);
  pictures.mask = (truth != 0);
  pictures.mask(new_body) = 255;
  const ColourShares colours = {};
  const cv::Mat1w numbers = AssignPixels(pictures, last, {Moving(1, kBackStep, colours)});
  EXPECT_EQ(numbers(30, 116), 0);
  EXPECT_EQ(numbers(20, 30), 1);
}

}  // namespace
}  // namespace egosieve::vision
