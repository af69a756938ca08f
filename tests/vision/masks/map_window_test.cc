#include "vision/masks/map_window.h"

#include <cmath>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gtest/gtest.h"
#include "vision/masks/motion_split.h"
#include "vision/masks/mover_motion.h"
#include "vision/masks/mover_tracker.h"
#include "vision/masks/moving_cells.h"

namespace egosieve::vision {
namespace {

constexpr int kWidth = 160, kHeight = 120;

FlowPair ConstantFlow(cv::Size size, cv::Point2f motion) {
  return {cv::Mat(size, CV_32FC2, cv::Scalar(motion.x, motion.y)),
          cv::Mat(size, CV_32FC2, cv::Scalar(-motion.x, -motion.y))};
}

// Smooth texture, so that flow has something to hold.
cv::Mat3b Texture(uint64_t seed) {
  cv::Mat3b image(kHeight, kWidth);
  cv::RNG random(seed);
  random.fill(image, cv::RNG::UNIFORM, 40, 160);
  cv::GaussianBlur(image, image, {}, 1.5);
  return image;
}

TEST(LinkMaps, CarriesEvidenceAlongTheFlow) {
  std::vector<LinkFrame> frames(3);
  for (int t = 0; t < 3; ++t) {
    frames[t].time_seconds = 0.1 * t;
    frames[t].log_odds = cv::Mat1f::zeros(40, 60);
    if (t > 0) frames[t].flow = ConstantFlow({60, 40}, {5.0f, 0.0f});
    frames[t].errors = ReturnErrorsOf(frames[t].flow);
  }
  frames[0].has_map = false;
  frames[1].log_odds(20, 30) = 4.0f;
  const std::vector<cv::Mat1f> linked = LinkMaps(frames, {});
  const float fading = static_cast<float>(std::exp(-0.1 / TemporalLinkOptions().memory_seconds));
  // Frame 0 has no map of its own: it has its future's, frames 1 and 2, where these are.
  EXPECT_NEAR(linked[0](20, 25), 4.0f / (1.0f + fading), 1e-4);
  EXPECT_NEAR(linked[2](20, 35), 4.0f * fading / (1.0f + fading), 1e-4);
  EXPECT_EQ(linked[0](10, 10), 0.0f);
  const std::vector<cv::Mat1f> from_past = LinkMaps(frames, {.causal = true});
  EXPECT_EQ(cv::countNonZero(from_past[0]), 0);
  EXPECT_NEAR(from_past[2](20, 35), 4.0f * fading / (1.0f + fading), 1e-4);
}

TEST(LinkMaps, TakesNothingOverWhereFlowDoesNotHold) {
  std::vector<LinkFrame> frames(2);
  for (LinkFrame& frame : frames) frame.log_odds = cv::Mat1f(40, 60, 1.0f);
  frames[0].log_odds.setTo(-1.0f);
  frames[1].time_seconds = 0.1;
  frames[1].flow = ConstantFlow({60, 40}, {9.0f, 0.0f});
  frames[1].flow.backward.setTo(cv::Scalar(9.0, 0.0));  // does not return: 18 pixels off
  frames[1].errors = ReturnErrorsOf(frames[1].flow);
  EXPECT_NEAR(LinkMaps(frames, {})[1](20, 30), 1.0f, 1e-6);
  frames[1].flow = {};
  EXPECT_EQ(LinkMaps(frames, {})[1](20, 30), 1.0f);
}

// (C3) of one picture, B G R.
cv::Mat1f EvidenceIn(const cv::Mat3b& image, const cv::Mat1f& probability) {
  cv::Mat3b lab;
  cv::cvtColor(image, lab, cv::COLOR_BGR2Lab);
  return ColourEvidence({lab}, {probability}, 4.0f)[0];
}

TEST(ColourEvidence, KnowsColoursOfBothKindsAndNoOthers) {
  cv::Mat3b image(100, 100, cv::Vec3b(40, 40, 40));
  image(cv::Rect(0, 0, 50, 100)) = cv::Vec3b(40, 40, 220);
  cv::Mat1f p(image.size(), 0.05f);
  p(cv::Rect(0, 0, 40, 100)) = 0.95f;
  const cv::Mat1f evidence = EvidenceIn(image, p);
  EXPECT_GT(evidence(50, 45), 0.5f);  // a likely colour where the map missed it
  EXPECT_LT(evidence(50, 80), -1.5f);
  double low = 0.0, high = 0.0;
  cv::minMaxLoc(evidence, &low, &high);
  EXPECT_GE(low, -4.0);
  EXPECT_LE(high, 4.0);
  // Nothing moves, and nothing stands.
  for (const float of_all : {0.0f, 0.002f, 1.0f}) {
    const cv::Mat1f same(image.size(), of_all);
    EXPECT_LT(cv::norm(EvidenceIn(image, same), cv::NORM_INF), 0.01) << of_all;
  }
}

TEST(ColourEvidence, TellsMoversFromWhatIsAroundThem) {
  // Grey movers on green; grey mountains far away, with ten times as many pixels as the movers.
  cv::Mat3b image(200, 200, cv::Vec3b(60, 160, 60));
  image(cv::Rect(0, 0, 200, 60)) = cv::Vec3b(120, 120, 120);
  image(cv::Rect(90, 150, 34, 34)) = cv::Vec3b(120, 120, 120);
  cv::Mat1f p(image.size(), 0.02f);
  p(cv::Rect(90, 150, 20, 34)) = 0.98f;  // the map misses the rest
  EXPECT_GT(EvidenceIn(image, p)(165, 118), 1.0f);
}

TEST(RefineProbability, MovesTheStepToTheEdge) {
  cv::Mat3b image(kHeight, kWidth, cv::Vec3b(60, 60, 60));
  image(cv::Rect(80, 0, 80, kHeight)) = cv::Vec3b(180, 180, 180);
  cv::Mat1f log_odds(kHeight, kWidth, -3.0f);
  log_odds(cv::Rect(86, 0, 74, kHeight)) = 3.0f;  // six pixels beside the edge
  const cv::Mat1f p = RefineProbability(image, log_odds);
  EXPECT_GT(p(60, 82), 0.5f);
  EXPECT_LT(p(60, 77), 0.2f);
  // What is unsure stays so.
  const cv::Mat1f unsure = RefineProbability(image, cv::Mat1f::zeros(kHeight, kWidth));
  EXPECT_LT(cv::norm(unsure - 0.5f, cv::NORM_INF), 1e-3);
}

TEST(RefineProbability, ReachesAsFarAtEveryResolution) {
  const auto refined = [](int side) {
    // A strip of the picture, without edges, with a step of the map in the middle.
    const cv::Mat3b image(16, side, cv::Vec3b(60, 60, 60));
    cv::Mat1f log_odds(image.size(), -3.0f);
    log_odds(cv::Rect(side / 2, 0, side / 2, 16)) = 3.0f;
    return RefineProbability(image, log_odds);
  };
  const cv::Mat1f small = refined(400), large = refined(1600);
  for (const double place : {0.4, 0.45, 0.48, 0.55, 0.6}) {
    EXPECT_NEAR(small(8, static_cast<int>(place * 400)), large(8, static_cast<int>(place * 1600)),
                0.02)
        << place;
  }
  // The filter sweeps with r, r / 2 and r / 4, one after the other. Each sweep by itself makes a step
  // fall as exp(-x / r); all three as the sum of their exponentials by partial fractions.
  const double low = 1.0 / (1.0 + std::exp(3.0)), x = 19.5 / 20.0;  // of the middle of pixel 180
  const double falls =
      (64.0 * std::exp(-x) - 20.0 * std::exp(-2.0 * x) + std::exp(-4.0 * x)) / 45.0;
  EXPECT_NEAR(small(8, 180), low + (0.5 - low) * falls, 0.002);
}

TEST(LogOdds, AreTheInverseOfProbabilities) {
  const cv::Mat1f p = (cv::Mat1f(1, 3) << 0.1f, 0.5f, 0.9f);
  EXPECT_LT(cv::norm(Probability(LogOdds(p)) - p, cv::NORM_INF), 1e-6);
  EXPECT_TRUE(cv::checkRange(LogOdds((cv::Mat1f(1, 2) << 0.0f, 1.0f))));
}

TEST(MapWindow, ACutSeparatesScenes) {
  std::vector<WindowFrame> frames;
  for (int t = 0; t < 4; ++t) {
    frames.push_back(MakeWindowFrame(0.1 * t, Texture(t < 2 ? 1 : 9),
                                     cv::Mat1f(kHeight, kWidth, t < 2 ? 0.9f : 0.1f), true));
  }
  ASSERT_TRUE(LinkFrames(frames).ok());
  EXPECT_FALSE(frames[1].flow.forward.empty());
  EXPECT_TRUE(frames[2].flow.forward.empty());
  EXPECT_FALSE(frames[3].flow.forward.empty());
  const std::vector<cv::Mat1f> refined = RefineWindow(frames, 1, 2, {});
  ASSERT_EQ(refined.size(), 2u);
  EXPECT_GT(cv::mean(refined[0])[0], 0.9);
  EXPECT_LT(cv::mean(refined[1])[0], 0.1);
}

TEST(MapWindow, WhatOneMapAloneSaysChangesLittle) {
  // A still scene. In frame 2 the map's edge lies 12 pixels further.
  std::vector<WindowFrame> frames;
  for (int t = 0; t < 5; ++t) {
    cv::Mat1f p(kHeight, kWidth, 0.05f);
    p.colRange(t == 2 ? 92 : 80, kWidth) = 0.95f;
    const cv::Mat3b image(kHeight, kWidth, cv::Vec3b(60, 60, 60));
    frames.push_back(MakeWindowFrame(0.1 * t, image, p, true));
    if (t > 0) frames.back().flow = ConstantFlow({kWidth, kHeight}, {0.0f, 0.0f});
    frames.back().errors = ReturnErrorsOf(frames.back().flow);
  }
  MapWindowOptions options;
  options.shot.colour_limit = 1e-6f;
  options.shot.within = options.shot.along = 0.0f;
  options.link.memory_seconds = 1e-3;
  const auto change = [&] {
    const std::vector<cv::Mat1f> refined = RefineWindow(frames, 1, 2, options);
    return cv::countNonZero((refined[0] >= 0.5f) != (refined[1] >= 0.5f));
  };
  EXPECT_LE(change(), 4 * kHeight);
  options.steady_seconds = 1e-3;
  EXPECT_GE(change(), 10 * kHeight);
}

// A grey box on a textured ground that stands still. The map shows the box's rim alone.
LinkFrame BoxWithRim(const cv::Mat3b& ground, const cv::Rect& box, float inside) {
  LinkFrame frame;
  frame.image = ground.clone();
  frame.image(box) = cv::Vec3b(200, 200, 200);
  frame.log_odds = cv::Mat1f(ground.size(), -4.0f);
  frame.log_odds(box) = 3.0f;
  frame.log_odds(box - cv::Size(24, 24) + cv::Point(12, 12)) = inside;
  return frame;
}

TEST(SegmentShot, FillsAMoverWhoseMiddleTheMapMisses) {
  const cv::Rect box(50, 40, 60, 50);
  const cv::Mat1f joined = SegmentShot({BoxWithRim(Texture(1), box, -1.0f)}, {})[0];
  EXPECT_GT(joined(65, 80), 0.0f);
  EXPECT_LT(joined(20, 20), -4.0f);
  ShotSegmentationOptions apart;  // neither edges nor colours
  apart.within = 0.0f;
  apart.colour_limit = 1e-6f;
  EXPECT_LT(SegmentShot({BoxWithRim(Texture(1), box, -1.0f)}, apart)[0](65, 80), 0.0f);
}

TEST(SegmentShot, DecidesNothingWhereNothingIsKnown) {
  for (const float of_all : {-1e-3f, 0.0f, 1e-3f}) {
    std::vector<LinkFrame> shot(1);
    shot[0].image = Texture(1);
    shot[0].log_odds = cv::Mat1f(shot[0].image.size(), of_all);
    EXPECT_LT(cv::norm(SegmentShot(shot, {})[0], cv::NORM_INF), 0.1) << of_all;
  }
}

TEST(SegmentShot, FollowsFlowFromPictureToPicture) {
  // In the second picture the map says a little against the box, in the first much for it.
  const cv::Size size(kWidth, kHeight);
  std::vector<LinkFrame> shot(2);
  for (int t = 0; t < 2; ++t) {
    shot[t].image = cv::Mat3b(size, cv::Vec3b(90, 90, 90));
    shot[t].log_odds = cv::Mat1f(size, -3.0f);
  }
  shot[0].log_odds(cv::Rect(40, 40, 40, 40)) = 5.0f;
  shot[1].log_odds(cv::Rect(50, 40, 40, 40)) = -1.0f;
  shot[1].flow.backward = cv::Mat(size, CV_32FC2, cv::Scalar(-10.0, 0.0));
  shot[1].errors.backward = cv::Mat1f(size, 0.0f);  // it returns exactly
  const ShotSegmentationOptions options{.within = 0.0f, .colour_limit = 1e-6f};
  EXPECT_NEAR(SegmentShot(shot, options)[1](60, 85), -1.0f + 2.0f, 1e-3);
  EXPECT_NEAR(SegmentShot(shot, options)[1](60, 95), -3.0f - 2.0f, 1e-3);
  shot[1].errors.backward.setTo(1e6f);
  EXPECT_NEAR(SegmentShot(shot, options)[1](60, 85), -1.0f - 2.0f, 1e-3);
}

TEST(WorkingStep, BoundsTheLongerSide) {
  EXPECT_EQ(WorkingStep({640, 360}), 1);
  EXPECT_EQ(WorkingStep({1242, 375}), 2);
  EXPECT_EQ(WorkingStep({1080, 1920}), 3);
}

constexpr int kMaskWidth = 30, kMaskHeight = 10;

// 7 in the left third, 8 in the right one.
cv::Mat1w TwoMovers() {
  cv::Mat1w numbers(kMaskHeight, kMaskWidth, uint16_t{0});
  numbers(cv::Rect(0, 0, 10, kMaskHeight)) = 7;
  numbers(cv::Rect(20, 0, 10, kMaskHeight)) = 8;
  return numbers;
}

TEST(DropGlimpses, DropsWhatTheNextFrameHasNowhere) {
  cv::Mat1w next = TwoMovers();
  next(cv::Rect(0, 0, 10, kMaskHeight)) = 0;
  cv::Mat1w numbers = TwoMovers();
  DropGlimpses({7, 8, 9}, next, numbers);
  EXPECT_EQ(cv::countNonZero(numbers == 7), 0);
  EXPECT_EQ(cv::countNonZero(numbers == 8), 10 * kMaskHeight);
}

TEST(DropGlimpses, WhatWasSeenBeforeStays) {
  cv::Mat1w numbers = TwoMovers();
  DropGlimpses({8}, cv::Mat1w(kMaskHeight, kMaskWidth, uint16_t{0}), numbers);
  EXPECT_EQ(cv::countNonZero(numbers == 7), 10 * kMaskHeight);
  EXPECT_EQ(cv::countNonZero(numbers == 8), 0);
}

TEST(DropGlimpses, WhatJoinsAnotherMoverStays) {
  for (const int columns : {4, 5}) {
    cv::Mat1w next(kMaskHeight, kMaskWidth, uint16_t{0});
    next(cv::Rect(0, 0, columns, kMaskHeight)) = 3;
    cv::Mat1w numbers = TwoMovers();
    DropGlimpses({7}, next, numbers);
    EXPECT_EQ(cv::countNonZero(numbers == 7), columns == 5 ? 10 * kMaskHeight : 0) << columns;
  }
}

const cv::Size kSize(160, 80);
const cv::Rect kRegion(20, 20, 80, 40);

cv::Mat1b Mask() {
  cv::Mat1b mask = cv::Mat1b::zeros(kSize);
  mask(kRegion) = 255;
  return mask;
}

// The region's cells, all of which hold over one horizon.
MovingCells CellsOf(const std::function<cv::Point2f(cv::Point2f place)>& step) {
  MovingCells cells = FollowCells(Mask(), {});
  MovingCells::Horizon horizon;
  for (const cv::Point2f& place : cells.places) horizon.displacement.push_back(step(place));
  horizon.holds.assign(cells.places.size(), 1);
  cells.horizons = {horizon};
  return cells;
}

std::vector<int> AllOf(const MovingCells& cells) {
  std::vector<int> all(cells.places.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

TEST(FitMotion, FindsAnAffineMotionBesideAThirdOfOutliers) {
  std::vector<cv::Point2f> places, steps;
  for (int i = 0; i < 300; ++i) {
    const cv::Point2f p(static_cast<float>(i % 20) * 5.0f, static_cast<float>(i / 20) * 5.0f);
    places.push_back(p);
    steps.emplace_back(3.0f + 0.02f * p.x, -1.0f + 0.02f * p.y);
    if (i % 3 == 0) steps.back() += cv::Point2f(20.0f, 9.0f);
  }
  const MoverMotion motion = FitMotion(places, steps, 0.7);
  // The stiffness takes 49 / (49 + the places' variance, 470 or more) off the gradient: 0.1 of 0.02
  // times at most 50 pixels; outliers, 22 pixels away, weigh 1e-6.
  EXPECT_NEAR(motion.At({90, 60}).x, 4.8, 0.1);
  EXPECT_NEAR(motion.At({90, 60}).y, 0.2, 0.1);
  const cv::Point2d source = motion.Source({50, 40});
  const cv::Point2d back = source + motion.At(source);
  EXPECT_NEAR(back.x, 50.0, 1e-9);
  EXPECT_NEAR(back.y, 40.0, 1e-9);
  EXPECT_EQ(FitMotion({}, {}, 0.7).At({5, 5}), cv::Point2d());
}

TEST(FollowCells, AddsStepsUpAndStopsAtTheBorderAndWhereFlowDoesNotReturn) {
  FlowPair flow = {cv::Mat(kSize, CV_32FC2, cv::Scalar(15.0, 0.0)),
                   cv::Mat(kSize, CV_32FC2, cv::Scalar(-15.0, 0.0))};
  const MovingCells cells = FollowCells(Mask(), std::vector<FlowPair>(5, flow));
  ASSERT_EQ(cells.horizons.size(), 5u);
  EXPECT_EQ(cells.cells.size(), 20u * 10u);
  EXPECT_FLOAT_EQ(cells.horizons[0].displacement[0].x, 75.0f);
  for (size_t i = 0; i < cells.places.size(); ++i) {
    EXPECT_EQ(cells.horizons[0].holds[i] != 0, cells.places[i].x + 75.0f <= 159.0f) << i;
  }
  flow.backward.setTo(cv::Scalar(15.0, 0.0));
  const MovingCells lost = FollowCells(Mask(), {flow});
  EXPECT_EQ(std::accumulate(lost.horizons[0].holds.begin(), lost.horizons[0].holds.end(), 0), 0);
}

TEST(SplitByMotion, SeparatesASmallPartBeforeALargeOne) {
  const cv::Rect small(48, 20, 12, 40);
  const MovingCells cells = CellsOf([&](cv::Point2f p) {
    return small.contains(cv::Point(p)) ? cv::Point2f(-12.0f, 0.0f) : cv::Point2f(12.0f, 1.0f);
  });
  const auto split = SplitByMotion(cells, AllOf(cells));
  ASSERT_TRUE(split.has_value());
  EXPECT_EQ(split->smaller.size(), 3u * 10u);
  EXPECT_EQ(split->larger.size(), 17u * 10u);
  for (const int i : split->smaller) EXPECT_TRUE(small.contains(cv::Point(cells.places[i])));
}

TEST(SplitByMotion, CellsThatGetHiddenGoWithTheirMotionOverFewerFrames) {
  const cv::Rect small(48, 20, 12, 40);
  MovingCells cells = CellsOf([&](cv::Point2f p) {
    return small.contains(cv::Point(p)) ? cv::Point2f(-12.0f, 0.0f) : cv::Point2f(12.0f, 1.0f);
  });
  MovingCells::Horizon two = cells.horizons[0];
  for (size_t i = 0; i < cells.places.size(); ++i) {
    two.displacement[i] *= 2.0f;
    if (cells.places[i].x > 36.0f && cells.places[i].x < 48.0f) two.holds[i] = 0;
  }
  cells.horizons.insert(cells.horizons.begin(), two);
  const auto split = SplitByMotion(cells, AllOf(cells));
  ASSERT_TRUE(split.has_value());
  EXPECT_EQ(split->smaller.size(), 3u * 10u);
  EXPECT_EQ(split->larger.size(), 17u * 10u);
}

TEST(SplitByMotion, KeepsTogetherWhatZoomsAndWhatSwingsByLessThanItsSize) {
  const MovingCells zoom =
      CellsOf([](cv::Point2f p) { return 0.1f * (p - cv::Point2f(60.0f, 40.0f)); });
  EXPECT_FALSE(SplitByMotion(zoom, AllOf(zoom)).has_value());
  // A limb of 16 x 20 pixels, 17.9 in size, that moves 6 pixels against the body; 12.5 would part
  // it.
  const auto swinging = [](float pixels) {
    return CellsOf([pixels](cv::Point2f p) {
      return cv::Rect(20, 40, 16, 20).contains(cv::Point(p)) ? cv::Point2f(3.0f + pixels, 0.0f)
                                                             : cv::Point2f(3.0f, 0.0f);
    });
  };
  const MovingCells limb = swinging(6.0f), parting = swinging(20.0f);
  EXPECT_FALSE(SplitByMotion(limb, AllOf(limb)).has_value());
  EXPECT_TRUE(SplitByMotion(parting, AllOf(parting)).has_value());
}

TEST(MotionDistance, IsBelowOneForPartsOfOneMotion) {
  const MovingCells cells = CellsOf([](cv::Point2f p) {
    return p.x < 60.0f ? cv::Point2f(6.0f, 0.0f) : cv::Point2f(6.0f, 3.0f);
  });
  std::vector<int> left, near, right;
  for (size_t i = 0; i < cells.places.size(); ++i) {
    const float x = cells.places[i].x;
    (x < 40.0f ? left : x < 60.0f ? near : right).push_back(static_cast<int>(i));
  }
  EXPECT_NEAR(MotionDistance(cells, left, near, 0.0).value_or(9.0), 0.0, 1e-6);
  EXPECT_NEAR(MotionDistance(cells, left, right, 0.0).value_or(0.0), 3.0 / 1.5, 1e-5);
  EXPECT_LT(MotionDistance(cells, left, right, 0.4).value_or(9.0), 1.0);
  EXPECT_FALSE(MotionDistance(cells, {}, right, 0.4).has_value());
}

}  // namespace
}  // namespace egosieve::vision
