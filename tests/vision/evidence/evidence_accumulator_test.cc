#include "vision/evidence/evidence_accumulator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/vision/evidence/point_street.h"

namespace egosieve::vision {
namespace {

constexpr int kGap = 2;

EvidenceFrame FrameOf(const PointStreet& street, int t, int start = 0) {
  EvidenceFrame frame{.index = t, .gap = kGap, .size = cv::Size(1242, 375)};
  if (t - kGap >= start) {
    frame.motion_model = MotionModelKind::kFundamental;
    frame.motion_matrix = street.Fundamental(t - kGap, t);
  }
  for (const Track& track : street.Tracks(t, start)) {
    frame.points.push_back(PointOfTrack(track, kGap));
  }
  return frame;
}

EvidenceAccumulator Accumulator(const EvidenceOptions& options = {}) {
  return *EvidenceAccumulator::Create(options);
}

StreetOptions Busy() {
  return {.mover_count = 80, .mover_travel = {0.02, 0.0, 1.5}, .noise_pixels = 0.2};
}

void ExpectSame(const EvidenceResult& a, const EvidenceResult& b) {
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(a.noise_pixels, b.noise_pixels);
  EXPECT_EQ(a.mover_share, b.mover_share);
  for (size_t i = 0; i < a.points.size(); ++i) {
    ASSERT_EQ(a.points[i].probability, b.points[i].probability);
    ASSERT_EQ(a.points[i].decided_by, b.points[i].decided_by);
  }
}

TEST(EvidenceAccumulator, CarsAheadThatPullAwayAreFoundByTheirDepth) {
  const PointStreet street(Busy());
  EvidenceAccumulator all = Accumulator(), epipolar = Accumulator([] {
                                             EvidenceOptions options;
                                             options.negative_depth = options.accumulation = false;
                                             return options;
                                           }());
  EvidenceResult result, plain;
  EvidenceFrame frame;
  for (int t = 0; t <= 5; ++t) {
    frame = FrameOf(street, t);
    result = *all.Add(frame);
    plain = *epipolar.Add(frame);
  }
  EXPECT_EQ(result.pose, PoseOutcome::kFound);
  EXPECT_TRUE(result.pose_line);
  int movers = 0, found = 0, found_plain = 0, by_depth = 0, statics = 0, mistaken = 0;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    if (!std::isfinite(frame.points[i].before.x)) continue;
    const bool dynamic = result.points[i].probability > 0.5;
    if (street.moves(frame.points[i].track_id)) {
      ++movers;
      found += dynamic ? 1 : 0;
      found_plain += plain.points[i].probability > 0.5 ? 1 : 0;
      by_depth += dynamic && result.points[i].decided_by == EvidenceTerm::kNegativeDepth ? 1 : 0;
    } else {
      ++statics;
      mistaken += dynamic ? 1 : 0;
    }
  }
  ASSERT_GT(movers, 60);
  ASSERT_GT(statics, 150);
  EXPECT_GT(found, 0.85 * movers);
  EXPECT_LT(found_plain, 0.3 * movers);
  EXPECT_GT(by_depth, 0.8 * found);
  EXPECT_LE(mistaken, 0.02 * statics);
}

TEST(EvidenceAccumulator, MemoryOutlastsFramesWithoutEvidenceAndFades) {
  const PointStreet street(Busy());
  EvidenceOptions options;
  options.forgetting = 0.8;  // half is left after three frames
  options.tempering = 0.5;
  EvidenceAccumulator accumulator = Accumulator(options);
  for (int t = 0; t <= 5; ++t) ASSERT_TRUE(accumulator.Add(FrameOf(street, t)).ok());
  double last = 1.0;
  for (int t = 6; t <= 8; ++t) {
    EvidenceFrame frame = FrameOf(street, t);
    frame.motion_model = MotionModelKind::kNone;
    const EvidenceResult result = *accumulator.Add(frame);
    double sum = 0.0;
    int movers = 0;
    for (size_t i = 0; i < frame.points.size(); ++i) {
      for (const bool present : result.points[i].present) EXPECT_FALSE(present);
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
  EvidenceAccumulator accumulator = Accumulator({.noise_memory = 0.0});
  EvidenceFrame frame;
  EvidenceResult result;
  for (int t = 0; t <= 5; ++t) {
    frame = FrameOf(street, t);
    for (EvidencePoint& point : frame.points) {
      point.estimates = street.moves(point.track_id) || point.track_id % 4 == 0;
    }
    result = *accumulator.Add(frame);
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
  EvidenceAccumulator accumulator = Accumulator();
  const EvidenceResult result = *accumulator.Add(FrameOf(street, 0));
  for (const PointEvidence& point : result.points) {
    EXPECT_FALSE(point.judged);
    EXPECT_EQ(point.probability, 0.5);
  }
}

TEST(EvidenceAccumulator, RestoredStateGoesOnBitForBit) {
  const PointStreet street(Busy());
  EvidenceAccumulator whole = Accumulator(), resumed = Accumulator();
  for (int t = 0; t <= 9; ++t) {
    EvidenceFrame frame = FrameOf(street, t);
    frame.grey = cv::Mat(frame.size, CV_8UC1);
    for (int y = 0; y < frame.grey.rows; ++y) {
      for (int x = 0; x < frame.grey.cols; ++x) {
        frame.grey.at<uint8_t>(y, x) = static_cast<uint8_t>((x * 7 + y * 13 + t * 3) % 256);
      }
    }
    EvidenceAccumulator fresh = Accumulator();
    ASSERT_TRUE(fresh.Restore(resumed.state()).ok());
    resumed = fresh;
    ExpectSame(*whole.Add(frame), *resumed.Add(frame));
  }
}

TEST(EvidenceAccumulator, StateIsBoundedByTheFrame) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator = Accumulator();
  for (int t = 0; t <= 12; ++t) {
    EvidenceFrame frame = FrameOf(street, t);
    frame.grey = cv::Mat(frame.size, CV_8UC1, cv::Scalar(7));
    for (EvidencePoint& point : frame.points) point.track_id += 100000 * t;  // all new
    ASSERT_TRUE(accumulator.Add(frame).ok());
    EXPECT_LE(accumulator.state().memories.size(), frame.points.size());
  }
}

TEST(EvidenceAccumulator, DepthIsAbsentWithoutTravelOrWithAHomography) {
  StreetOptions standing = Busy();
  standing.travel.setZero();
  standing.mover_travel.setZero();
  standing.yaw = 0.01;
  StreetOptions moved = standing;
  moved.travel = {0.0, 0.0, 1.0};
  const PointStreet street(standing), other(moved);
  EvidenceAccumulator accumulator = Accumulator();
  for (int t = 0; t <= 4; ++t) {
    EvidenceFrame frame = FrameOf(street, t);
    // The translation of this matrix is invented; its rotation is right.
    if (t >= kGap) frame.motion_matrix = other.Fundamental(t - kGap, t);
    const EvidenceResult result = *accumulator.Add(frame);
    EXPECT_NE(result.pose, PoseOutcome::kFound);
    for (const PointEvidence& point : result.points) {
      EXPECT_FALSE(point.present[static_cast<int>(EvidenceTerm::kNegativeDepth)]);
    }
  }
  const Eigen::Matrix3d k = street.camera().Matrix();
  EvidenceFrame frame = FrameOf(street, 5);
  frame.motion_model = MotionModelKind::kHomography;
  frame.motion_matrix = k * street.RotationBetween(3, 5) * k.inverse();
  const EvidenceResult result = *accumulator.Add(frame);
  // Turning on the spot: the homography explains all there is, up to the noise of both places.
  EXPECT_NEAR(result.noise_pixels, 0.2 * std::sqrt(2.0), 0.06);
  int judged = 0;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    const PointEvidence& point = result.points[i];
    EXPECT_FALSE(point.present[static_cast<int>(EvidenceTerm::kNegativeDepth)]);
    if (point.judged) ++judged;
    EXPECT_LE(point.probability, point.judged ? 0.4 : 0.5);
  }
  EXPECT_GT(judged, 300);
}

TEST(EvidenceAccumulator, ADroppedFrameLosesItsTracksAndNothingElse) {
  StreetOptions options = Busy();
  options.mover_count = 10;
  const PointStreet street(options);
  EvidenceAccumulator accumulator = Accumulator();
  for (int t = 0; t <= 4; ++t) ASSERT_TRUE(accumulator.Add(FrameOf(street, t)).ok());
  // Frames 5 to 7 never came; tracks start anew at 8, as a tracker would have it.
  const EvidenceResult first = *accumulator.Add(FrameOf(street, 8, 8));
  for (const PointEvidence& point : first.points) {
    for (const bool present : point.present) EXPECT_FALSE(present);
  }
  ASSERT_TRUE(accumulator.Add(FrameOf(street, 9, 8)).ok());
  EXPECT_EQ(accumulator.Add(FrameOf(street, 10, 8))->pose, PoseOutcome::kFound);
}

TEST(EvidenceAccumulator, ACutAndAnotherSizeStartAnew) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator = Accumulator();
  for (int t = 0; t <= 4; ++t) ASSERT_TRUE(accumulator.Add(FrameOf(street, t)).ok());
  EXPECT_FALSE(accumulator.state().memories.empty());
  EvidenceState with_road = accumulator.state();
  with_road.road = {true, true, 0.0, 0.1};
  ASSERT_TRUE(accumulator.Restore(with_road).ok());
  accumulator.Interrupt();
  EXPECT_FALSE(accumulator.state().road.known);
  EXPECT_TRUE(accumulator.state().memories.empty());
  EXPECT_TRUE(accumulator.state().has_noise);

  EvidenceFrame frame = FrameOf(street, 5);
  frame.size = cv::Size(1300, 400);
  ASSERT_TRUE(accumulator.Add(frame).ok());
  EXPECT_EQ(accumulator.state().size, frame.size);
}

// Matches at random, as over a cut: nothing may be claimed with depth, whatever the matrix.
TEST(EvidenceAccumulator, RandomMatchesGiveNoDepth) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator = Accumulator();
  EvidenceFrame frame = FrameOf(street, 3);
  std::mt19937_64 random(4);
  for (EvidencePoint& point : frame.points) {
    point.before =
        cv::Point2f(static_cast<float>(random() % 1242), static_cast<float>(random() % 375));
  }
  const EvidenceResult result = *accumulator.Add(frame);
  EXPECT_NE(result.pose, PoseOutcome::kFound);
}

TEST(EvidenceAccumulator, ErrorsLeaveTheStateUnchanged) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator = Accumulator();
  ASSERT_TRUE(accumulator.Add(FrameOf(street, 3)).ok());
  const auto refused = [&](const EvidenceFrame& frame) {
    return accumulator.Add(frame).status().code() == absl::StatusCode::kInvalidArgument;
  };
  EvidenceFrame frame = FrameOf(street, 3);
  EXPECT_TRUE(refused(frame));
  frame = FrameOf(street, 4);
  frame.gap = 0;
  EXPECT_TRUE(refused(frame));
  frame = FrameOf(street, 4);
  frame.size = {};
  EXPECT_TRUE(refused(frame));
  frame = FrameOf(street, 4);
  frame.grey = cv::Mat(10, 10, CV_8UC1);
  EXPECT_TRUE(refused(frame));
  frame = FrameOf(street, 4);
  frame.points[1].track_id = frame.points[0].track_id;
  EXPECT_TRUE(refused(frame));
  EXPECT_EQ(accumulator.state().last_index, 3);
  EXPECT_TRUE(accumulator.Add(FrameOf(street, 4)).ok());
}

TEST(EvidenceAccumulator, PlacesAndMatricesThatAreNoNumbers) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator = Accumulator();
  EvidenceFrame frame = FrameOf(street, 3);
  frame.points[0].now.x = std::nanf("");
  frame.points[1].before.y = INFINITY;
  EvidenceResult result = *accumulator.Add(frame);
  EXPECT_FALSE(result.points[0].judged);
  EXPECT_FALSE(result.points[1].judged);
  for (const PointEvidence& point : result.points) EXPECT_TRUE(std::isfinite(point.probability));
  frame = FrameOf(street, 4);
  frame.motion_matrix.setConstant(std::nan(""));
  result = *accumulator.Add(frame);
  EXPECT_EQ(result.noise_pixels, 0.0);
  EXPECT_TRUE(accumulator.Add(FrameOf(street, 5)).ok());
}

TEST(EvidenceAccumulator, TornStateAndBadOptionsAreRefused) {
  const PointStreet street(Busy());
  EvidenceAccumulator accumulator = Accumulator();
  ASSERT_TRUE(accumulator.Add(FrameOf(street, 3)).ok());
  EvidenceState state = accumulator.state();
  ASSERT_GT(state.memories.size(), 1U);
  std::swap(state.memories.front(), state.memories.back());
  EXPECT_FALSE(accumulator.Restore(state).ok());
  state = accumulator.state();
  state.mover_share = std::nan("");
  EXPECT_FALSE(accumulator.Restore(state).ok());
  EXPECT_FALSE(EvidenceAccumulator::Create(EvidenceOptions{.forgetting = 1.0}).ok());
  EXPECT_FALSE(EvidenceAccumulator::Create(EvidenceOptions{.tempering = std::nan("")}).ok());
  EXPECT_FALSE(EvidenceAccumulator::Create(EvidenceOptions{.focal_pixels = INFINITY}).ok());
}

}  // namespace
}  // namespace egosieve::vision
