// Pairs that are prepared ahead, on another thread: the same labels, and the work is done by then.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "tests/vision/labelling/same_labels.h"
#include "tests/vision/labelling/street_drive.h"
#include "vision/labelling/flow_cache.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

using Pictures = std::vector<std::shared_ptr<const ExtractedFrame>>;

constexpr int kAhead = 2;

Pictures Extracted(const FrameLabeller& labeller, int count) {
  Pictures pictures;
  for (const DrivePicture& picture :
       PicturesOf(EditedScenario("street", 1, [](Scene&) {}), 0, count)) {
    pictures.push_back(*labeller.Extract(picture.frame));
  }
  return pictures;
}

std::vector<LabelledFrame> LabelAll(FrameLabeller& labeller, const Pictures& pictures) {
  std::vector<LabelledFrame> labels;
  for (size_t t = 0; t < pictures.size(); ++t) {
    const size_t end = std::min(pictures.size(), t + 1 + kAhead);
    labels.push_back(
        *labeller.Label(pictures[t], Pictures(pictures.begin() + t + 1, pictures.begin() + end)));
  }
  return labels;
}

TEST(PreparedPairs, GiveTheSameLabelsBesideThemAndBefore) {
  FrameLabellerOptions options;
  options.focal_ratio = 0.65;
  const auto alone = *MakeFrameLabeller(options);
  const Pictures pictures = Extracted(*alone, 7);
  const std::vector<LabelledFrame> expected = LabelAll(*alone, pictures);
  for (const bool before : {true, false}) {
    const auto labeller = *MakeFrameLabeller(options);
    std::thread other([&] {
      for (size_t t = 1; t < pictures.size(); ++t) {
        EXPECT_TRUE(labeller->Prepare(*pictures[t - 1], *pictures[t]).ok());
      }
    });
    if (before) other.join();
    const std::vector<LabelledFrame> labels = LabelAll(*labeller, pictures);
    if (!before) other.join();
    for (size_t t = 0; t < pictures.size(); ++t) ExpectSame(expected[t], labels[t]);
    EXPECT_EQ(alone->state(), labeller->state());
    if (!before) continue;
    // The least of the frames whose last picture ahead is new: it is left to look the flow up.
    const auto least = [](const std::vector<LabelledFrame>& frames) {
      double least = frames[1].times.features_milliseconds;
      for (size_t t = 1; t + kAhead < frames.size(); ++t) {
        least = std::min(least, frames[t].times.features_milliseconds);
      }
      return least;
    };
    EXPECT_LT(least(labels), 0.25 * least(expected));
  }
}

TEST(FlowCache, ComputesEachFlowOnceForAllThreads) {
  const auto labeller = *MakeFrameLabeller({});
  const Pictures pictures = Extracted(*labeller, 3);
  FlowCache cache({});
  std::vector<std::shared_ptr<const FlowPair>> flows(4);
  std::vector<std::thread> threads;
  for (auto& flow : flows) {
    threads.emplace_back([&] { flow = *cache.Between(*pictures[0], *pictures[1]); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& flow : flows) EXPECT_EQ(flow, flows[0]);
  const auto later = *cache.Between(*pictures[1], *pictures[2]);
  EXPECT_NE(*cache.Between(*pictures[0], *pictures[2]), flows[0]);
  cache.Forget(pictures[1]->frame.index);
  EXPECT_EQ(*cache.Between(*pictures[1], *pictures[2]), later);
  EXPECT_NE(*cache.Between(*pictures[0], *pictures[1]), flows[0]);
}

}  // namespace
}  // namespace egosieve::vision
