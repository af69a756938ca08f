#include "vision/evidence/evidence_accumulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/vision/evidence/point_street.h"

namespace egosieve::vision {
namespace {

constexpr int kGap = 2;
const double kNoisePixels = 0.2 * std::sqrt(2.0);  // of Busy(), in both pictures

EvidencePoint PointOfTrack(const Track& track, int gap) {
  EvidencePoint point;
  point.track_id = track.id;
  point.parent_id = track.parent_id;
  point.now = track.places[0];
  if (track.Reaches(gap)) point.before = track.places[gap];
  return point;
}

// Inverse depths of the street's points are 1 / 8 to 1 / 100 metres.
TwoViewMotion MotionBetween(const PointStreet& street, int a, int b) {
  const Eigen::Vector3d t = street.TranslationBetween(a, b);
  TwoViewMotion motion;
  motion.found = true;
  motion.rotation = street.RotationBetween(a, b);
  motion.translation = t.normalized();
  motion.mean_parallax = 0.07 * t.norm();
  motion.noise = kNoisePixels / street.camera().focal_pixels;
  motion.static_share = 0.9;
  motion.moving_scale = 0.02;
  motion.noise_pixels = kNoisePixels;
  motion.parallax_pixels = 5.0;
  return motion;
}

EvidenceFrame FrameOf(const PointStreet& street, int t, int start = 0) {
  EvidenceFrame frame{.index = t, .size = cv::Size(1242, 375), .camera = street.camera()};
  if (t - kGap >= start) frame.world = MotionBetween(street, t - kGap, t);
  for (const Track& track : street.Tracks(t, start)) {
    frame.points.push_back(PointOfTrack(track, kGap));
  }
  return frame;
}

StreetOptions Busy() {
  return {.mover_count = 80, .mover_travel = {0.02, 0.0, 1.5}, .noise_pixels = 0.2};
}

void ExpectSame(const EvidenceResult& a, const EvidenceResult& b) {
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(a.mover_share, b.mover_share);
  for (size_t i = 0; i < a.points.size(); ++i) {
    ASSERT_EQ(a.points[i].probability, b.points[i].probability);
    ASSERT_EQ(a.points[i].decided_by, b.points[i].decided_by);
  }
}

// Along their epipolar lines, towards the point of expansion.
TEST(EvidenceAccumulator, CarsAheadThatPullAwayAreFound) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator;
  EvidenceResult result;
  EvidenceFrame frame;
  for (int t = 0; t <= 5; ++t) {
    frame = FrameOf(street, t);
    result = accumulator.Add(frame);
  }
  int movers = 0, found = 0, statics = 0, mistaken = 0;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    if (!std::isfinite(frame.points[i].before.x)) continue;
    const bool dynamic = result.points[i].probability > 0.5;
    if (street.moves(frame.points[i].track_id)) {
      ++movers;
      found += dynamic ? 1 : 0;
    } else {
      ++statics;
      mistaken += dynamic ? 1 : 0;
    }
  }
  ASSERT_GT(movers, 60);
  ASSERT_GT(statics, 150);
  EXPECT_GT(found, 0.85 * movers);
  EXPECT_LE(mistaken, 0.02 * statics);
}

TEST(EvidenceAccumulator, MemoryOutlastsFramesWithoutEvidenceAndFades) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator;
  for (int t = 0; t <= 5; ++t) accumulator.Add(FrameOf(street, t));
  double last = 1.0;
  for (int t = 6; t <= 8; ++t) {
    EvidenceFrame frame = FrameOf(street, t);
    frame.world.reset();
    const EvidenceResult result = accumulator.Add(frame);
    double sum = 0.0;
    int movers = 0;
    for (size_t i = 0; i < frame.points.size(); ++i) {
      for (const auto& ratio : result.points[i].of_pair) EXPECT_FALSE(ratio);
      if (!street.moves(frame.points[i].track_id) || !result.points[i].judged) continue;
      sum += result.points[i].probability;
      ++movers;
    }
    ASSERT_GT(movers, 40);
    EXPECT_GT(sum / movers, 0.6);
    EXPECT_LE(sum / movers, last);
    last = sum / movers;
  }
}

// Sky and asphalt, which are blank, do not take part in estimating the motion.
TEST(EvidenceAccumulator, TheShareOfMoversIsThatOfBlankPointsToo) {
  StreetOptions scene = Busy();
  scene.mover_count = 20;
  const PointStreet street(scene);
  EvidenceAccumulator accumulator;
  EvidenceFrame frame;
  EvidenceResult result;
  for (int t = 0; t <= 5; ++t) {
    frame = FrameOf(street, t);
    for (EvidencePoint& point : frame.points) {
      point.estimates = street.moves(point.track_id) || point.track_id % 4 == 0;
    }
    result = accumulator.Add(frame);
  }
  double movers = 0.0, judged = 0.0, estimating = 0.0;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    if (!result.points[i].judged) continue;
    judged += 1.0;
    movers += street.moves(frame.points[i].track_id) ? 1.0 : 0.0;
    estimating += frame.points[i].estimates ? 1.0 : 0.0;
  }
  ASSERT_LT(estimating, 0.4 * judged);
  EXPECT_LT(std::abs(result.mover_share - movers / judged),
            std::abs(result.mover_share - movers / estimating));
}

TEST(EvidenceAccumulator, NewPointsWithoutEvidenceAreNotJudged) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator;
  const EvidenceResult result = accumulator.Add(FrameOf(street, 0));
  for (const PointEvidence& point : result.points) {
    EXPECT_FALSE(point.judged);
    EXPECT_EQ(point.probability, 0.5);
  }
}

TEST(EvidenceAccumulator, RestoredStateGoesOnBitForBit) {
  const PointStreet street(Busy());
  EvidenceAccumulator whole, resumed;
  for (int t = 0; t <= 9; ++t) {
    EvidenceFrame frame = FrameOf(street, t);
    frame.grey = cv::Mat(frame.size, CV_8UC1);
    for (int y = 0; y < frame.grey.rows; ++y) {
      for (int x = 0; x < frame.grey.cols; ++x) {
        frame.grey.at<uint8_t>(y, x) = static_cast<uint8_t>((x * 7 + y * 13 + t * 3) % 256);
      }
    }
    EvidenceAccumulator fresh;
    ASSERT_TRUE(fresh.Restore(resumed.state()).ok());
    resumed = fresh;
    ExpectSame(whole.Add(frame), resumed.Add(frame));
  }
}

TEST(EvidenceAccumulator, StateIsBoundedByTheFrame) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator;
  for (int t = 0; t <= 12; ++t) {
    EvidenceFrame frame = FrameOf(street, t);
    frame.grey = cv::Mat(frame.size, CV_8UC1, cv::Scalar(7));
    for (EvidencePoint& point : frame.points) point.track_id += 100000 * t;  // all new
    accumulator.Add(frame);
    EXPECT_LE(accumulator.state().memories.size(), frame.points.size());
  }
}

TEST(EvidenceAccumulator, ADroppedFrameLosesItsTracksAndNothingElse) {
  StreetOptions options = Busy();
  options.mover_count = 10;
  const PointStreet street(options);
  EvidenceAccumulator accumulator;
  for (int t = 0; t <= 4; ++t) accumulator.Add(FrameOf(street, t));
  // Frames 5 to 7 never came; tracks start anew at 8, as a tracker would have it.
  const EvidenceResult first = accumulator.Add(FrameOf(street, 8, 8));
  for (const PointEvidence& point : first.points) {
    for (const auto& ratio : point.of_pair) EXPECT_FALSE(ratio);
  }
  accumulator.Add(FrameOf(street, 9, 8));
  const EvidenceResult third = accumulator.Add(FrameOf(street, 10, 8));
  EXPECT_TRUE(std::any_of(third.points.begin(), third.points.end(),
                          [](const PointEvidence& point) { return point.judged; }));
}

TEST(EvidenceAccumulator, ACutAndAnotherSizeStartAnew) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator;
  for (int t = 0; t <= 4; ++t) accumulator.Add(FrameOf(street, t));
  EXPECT_FALSE(accumulator.state().memories.empty());
  accumulator.Interrupt();
  EXPECT_TRUE(accumulator.state().memories.empty());

  EvidenceFrame frame = FrameOf(street, 5);
  frame.size = cv::Size(1300, 400);
  accumulator.Add(frame);
  EXPECT_EQ(accumulator.state().size, frame.size);
}

TEST(EvidenceAccumulator, PlacesThatAreNoNumbersAreNotJudged) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator;
  EvidenceFrame frame = FrameOf(street, 3);
  frame.points[0].now.x = std::nanf("");
  frame.points[1].before.y = INFINITY;
  const EvidenceResult result = accumulator.Add(frame);
  EXPECT_FALSE(result.points[0].judged);
  EXPECT_FALSE(result.points[1].judged);
  for (const PointEvidence& point : result.points) EXPECT_TRUE(std::isfinite(point.probability));
}

TEST(EvidenceAccumulator, ATornStateIsRefused) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator;
  accumulator.Add(FrameOf(street, 3));
  EvidenceState state = accumulator.state();
  ASSERT_GT(state.memories.size(), 1U);
  std::swap(state.memories.front(), state.memories.back());
  EXPECT_FALSE(accumulator.Restore(state).ok());
  state = accumulator.state();
  state.mover_share = std::nan("");
  EXPECT_FALSE(accumulator.Restore(state).ok());
}

}  // namespace
}  // namespace egosieve::vision
