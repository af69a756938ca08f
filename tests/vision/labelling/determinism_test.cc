// The same bytes on real video with 1, 2 and 4 threads, our own and OpenCV's. Built for every frame
// of the data it takes many minutes; the suite takes the first frames of a few sequences.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <variant>
#include <vector>

#include "tests/vision/labelling/same_labels.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

#ifdef EGOSIEVE_EVERY_FRAME
constexpr int kFramesOfAnInput = 1 << 30;
constexpr const char* kInputs[] = {
    "davis/car-shadow/frames",        "davis/horsejump-high/frames",
    "davis/bmx-trees/frames",         "davis/cows/frames",
    "kt3dmoseg/Seq005_Clip01/frames", "kt3dmoseg/Seq013_Clip02/frames",
    "kt3dmoseg/Seq028_Clip01/frames", "kitti-residential/frames",
    "highway/solidWhiteRight.mp4",    "highway/vehicle_test_video.mp4"};
#else
constexpr int kFramesOfAnInput = 3;
constexpr const char* kInputs[] = {"davis/bmx-trees/frames", "kt3dmoseg/Seq013_Clip02/frames"};
#endif

// Labellers of 1, 2 and 4 threads, frame by frame side by side. Returns the frames compared.
int64_t CompareThreads(const std::string& input, FrameLabellerOptions options) {
  constexpr int kThreads[] = {1, 2, 4};
  std::vector<std::unique_ptr<FrameLabeller>> labellers;
  for (const int threads : kThreads) {
    options.threads = threads;
    labellers.push_back(*MakeFrameLabeller(options));
  }
  auto source = OpenFrameSource(input);
  EXPECT_TRUE(source.ok()) << source.status();
  if (!source.ok()) return 0;
  int64_t frames = 0;
  while (frames < kFramesOfAnInput && !::testing::Test::HasFailure()) {
    const auto read = (*source)->Next();
    EXPECT_TRUE(read.ok()) << read.status();
    if (!read.ok() || !std::holds_alternative<Frame>(*read)) break;
    ++frames;
    absl::StatusOr<LabelledFrame> reference;
    for (size_t i = 0; i < labellers.size(); ++i) {
      cv::setNumThreads(kThreads[i]);
      const auto labelled = labellers[i]->Process(std::get<Frame>(*read));
      EXPECT_TRUE(labelled.ok()) << labelled.status();
      if (!labelled.ok()) return frames;
      if (i == 0) {
        reference = *labelled;
        continue;
      }
      SCOPED_TRACE(input + ", frame " + std::to_string(labelled->frame_index) + ", " +
                   std::to_string(kThreads[i]) + " threads");
      ExpectSame(*reference, *labelled);
      EXPECT_EQ(labellers[0]->state(), labellers[i]->state());
    }
  }
  return frames;
}

TEST(Determinism, SameBytesForOneTwoAndFourThreads) {
  const char* folder = std::getenv("EGOSIEVE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
  const int pool = cv::getNumThreads();
  for (const char* input : kInputs) {
    int64_t frames = 0;
    for (const auto& options : {FrameLabellerOptions(), FrameLabellerOptions::Paper()}) {
      frames = CompareThreads(std::string(folder) + "/" + input, options);
      EXPECT_GE(frames, 3) << input;
    }
    std::printf("%-34s %lld frames\n", input, static_cast<long long>(frames));
  }
  cv::setNumThreads(pool);
}

}  // namespace
}  // namespace egosieve::vision
