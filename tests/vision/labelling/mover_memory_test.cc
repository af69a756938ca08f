#include "vision/labelling/mover_memory.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/vision/labelling/street_drive.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {
namespace {

constexpr int kStride = 5;
const cv::Size kImage(50, 30);  // 10 x 6 nodes, the first at (2, 2)

TrackedPoint At(float x, float y) {
  TrackedPoint point;
  point.evidence.now = {x, y};
  return point;
}

PointEvidence Judged(double probability) {
  PointEvidence evidence;
  evidence.judged = true;
  evidence.probability = probability;
  return evidence;
}

TEST(MoverMemory, GoesWithTheLinks) {
  MoverMemory memory(kStride);
  EXPECT_TRUE(memory.CarriedBy({{2, 2, 7, 2}}, kImage).empty());
  EvidenceResult evidence;
  evidence.points = {Judged(0.9), Judged(0.2), PointEvidence(), Judged(0.8)};
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
  MoverMemory memory(kStride);
  EvidenceResult evidence;
  evidence.points = {Judged(0.9), Judged(0.7)};
  memory.Remember({At(2, 7), At(47, 27)}, evidence, wide);
  EXPECT_EQ(memory.At(memory.nodes(), {50.0f, 2.0f}, wide), 0.0f);
  EXPECT_FLOAT_EQ(memory.At(memory.nodes(), {50.0f, 29.0f}, wide), 0.7f);
}

// Buses come to fill more than half of the picture, while the camera goes on. Without the term of
// accumulation, to which the memory belongs, the bus is the world in many of these frames.
TEST(MoverMemory, ABusThatFillsThePictureMoves) {
  const Scenario scenario = EditedScenario("bus_stop", 1, [](Scene&) {});
  const std::vector<DrivePicture> pictures = PicturesOf(scenario, 55, 45);
  FrameLabellerOptions options;
  options.frame_gap = 1;
  options.threads = 1;
  options.focal_ratio = scenario.intrinsics().focal_pixels / scenario.options().width_pixels;
  const auto labelled = [&](bool remembers) {
    options.evidence.accumulation = remembers;
    const std::unique_ptr<FrameLabeller> labeller = MakeLabeller(options);
    LabelCounts counts;
    for (const DrivePicture& picture : pictures) {
      counts.Add(Count(*labeller->Process(picture.frame), picture.movers));
    }
    return counts;
  };
  const LabelCounts with = labelled(true), without = labelled(false);
  EXPECT_LT(with.FalseShare(), 0.02);
  EXPECT_GT(with.FoundShare(), 0.85);
  EXPECT_GT(without.FalseShare(), 0.1);
}

}  // namespace
}  // namespace egosieve::vision
