// What the road says by a pair of pictures ahead.
#include <gtest/gtest.h>

#include "tests/vision/evidence/road_view.h"
#include "vision/evidence/evidence_accumulator.h"

namespace egosieve::vision {
namespace {

// road_view.h has where the places were in a picture before; here that picture is one ahead.
EvidenceFrame FrameBeforeRoadView(const View& view, double ground_heights) {
  EvidenceFrame frame;
  frame.index = 1;
  frame.size = kImage;
  frame.camera = view.camera;
  EvidenceView& ahead = frame.views.emplace_back();
  ahead.pictures = 5;
  ahead.motion.found = true;
  ahead.motion.translation = Eigen::Vector3d::UnitZ();
  ahead.motion.mean_parallax = 0.05;
  ahead.motion.noise_pixels = 0.1;
  ahead.motion.noise = 0.1 / view.camera.focal_pixels;
  ahead.motion.static_share = 0.9;
  ahead.motion.moving_scale = 0.02;
  ahead.motion.parallax_pixels = 3.0;
  ahead.motion.ground_heights = ground_heights;
  ahead.motion.travel = Eigen::Vector3d::UnitZ();
  for (size_t i = 0; i < view.places.size(); ++i) {
    EvidencePoint& point = frame.points.emplace_back();
    point.now = view.places[i];
    ahead.places.emplace_back(static_cast<float>(view.pairs[i].x1),
                              static_cast<float>(view.pairs[i].y1));
  }
  return frame;
}

// Over the points of one kind.
template <typename Value>
double MeanOf(const View& view, const EvidenceResult& result, What what, const Value& value) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < result.points.size(); ++i) {
    if (view.what[i] != what) continue;
    ++count;
    sum += value(result.points[i]);
  }
  return sum / count;
}

double MeanRoadRatioAhead(const View& view, const EvidenceResult& result, What what) {
  return MeanOf(view, result, what, [](const PointEvidence& point) {
    return point.views_road_log_ratio.value_or(0.0);
  });
}

double MeanProbability(const View& view, const EvidenceResult& result, What what) {
  return MeanOf(view, result, what, [](const PointEvidence& point) { return point.probability; });
}

TEST(RoadAhead, APairAheadTellsCarsByTheGround) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator = *EvidenceAccumulator::Create({});
  const EvidenceResult result = *accumulator.Add(FrameBeforeRoadView(view, kTravel / kHeight));
  EXPECT_FALSE(result.road);  // of no pair behind
  EXPECT_GT(MeanRoadRatioAhead(view, result, What::kAhead), 4.0);
  EXPECT_GT(MeanRoadRatioAhead(view, result, What::kOncoming), 4.0);
  EXPECT_LT(MeanRoadRatioAhead(view, result, What::kStanding), 0.1);
  EXPECT_LT(MeanRoadRatioAhead(view, result, What::kRoad), 0.1);
  // It is a part of the probability, of cars that move along their epipolar lines.
  EXPECT_GT(MeanProbability(view, result, What::kOncoming), 0.6);
  EvidenceOptions options;
  options.road = false;
  EvidenceAccumulator without = *EvidenceAccumulator::Create(options);
  const EvidenceResult plain = *without.Add(FrameBeforeRoadView(view, kTravel / kHeight));
  EXPECT_EQ(MeanRoadRatioAhead(view, plain, What::kAhead), 0.0);
  EXPECT_LT(MeanProbability(view, plain, What::kOncoming), 0.3);
}

// A plane that only the pair ahead shows is not believed.
TEST(RoadAhead, APairAheadNeedsAGroundThatIsKnown) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator = *EvidenceAccumulator::Create({});
  const EvidenceResult result = *accumulator.Add(FrameBeforeRoadView(view, 0.0));
  for (const PointEvidence& point : result.points) EXPECT_FALSE(point.views_road_log_ratio);
}

// Where the camera moves to is its horizon only if it keeps its direction of travel.
TEST(RoadAhead, AHandHeldCameraHasNoKnownGround) {
  const View view = MakeView(0.05);
  EvidenceFrame frame = FrameBeforeRoadView(view, kTravel / kHeight);
  frame.views[0].motion.travel.reset();
  EvidenceAccumulator accumulator = *EvidenceAccumulator::Create({});
  const EvidenceResult result = *accumulator.Add(frame);
  for (const PointEvidence& point : result.points) EXPECT_FALSE(point.views_road_log_ratio);
}

// Flow stays at nought on a blank road, which shows no plane then.
TEST(RoadAhead, AKnownGroundReplacesARoadThatFlowDoesNotShow) {
  View view = MakeView(0.05);
  for (size_t i = 0; i < view.places.size(); ++i) {
    if (view.what[i] != What::kRoad) continue;
    view.pairs[i].x1 = view.places[i].x;
    view.pairs[i].y1 = view.places[i].y;
  }
  EvidenceAccumulator accumulator = *EvidenceAccumulator::Create({});
  const EvidenceResult result = *accumulator.Add(FrameBeforeRoadView(view, kTravel / kHeight));
  EXPECT_GT(MeanRoadRatioAhead(view, result, What::kAhead), 3.0);
  EXPECT_LT(MeanRoadRatioAhead(view, result, What::kStanding), 0.1);
}

}  // namespace
}  // namespace egosieve::vision
