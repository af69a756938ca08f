// The same bytes on real video with 1, 2 and 4 threads, our own and OpenCV's.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/testing/status.h"
#include "tests/vision/labelling/real_inputs.h"
#include "tests/vision/labelling/same_labels.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

// Two sequences are enough of the first frames.
std::vector<std::string> Inputs() {
  if (AllFrames()) return RealInputs();
  return {"davis/bmx-trees/frames", "kt3dmoseg/Seq013_Clip02/frames"};
}

// Labellers of 1, 2 and 4 threads, frame by frame side by side. Returns the frames compared.
int64_t CompareThreads(const std::string& input, FrameLabellerOptions options) {
  constexpr int kThreads[] = {1, 2, 4};
  std::vector<std::unique_ptr<FrameLabeller>> labellers;
  for (const int threads : kThreads) {
    options.threads = threads;
    labellers.push_back(*MakeFrameLabeller(options));
  }
  auto source = Value(OpenFrameSource(input));
  int64_t frames = 0;
  while ((frames < 3 || AllFrames()) && !::testing::Test::HasFailure()) {
    const auto read = Value(source->Next());
    if (!std::holds_alternative<Frame>(read)) break;
    ++frames;
    LabelledFrame reference;
    for (size_t i = 0; i < labellers.size(); ++i) {
      cv::setNumThreads(kThreads[i]);
      const LabelledFrame labelled = Value(labellers[i]->Process(std::get<Frame>(read)));
      if (i == 0) reference = labelled;
      SCOPED_TRACE(input + ", frame " + std::to_string(labelled.frame_index) + ", " +
                   std::to_string(kThreads[i]) + " threads");
      ExpectSame(reference, labelled);
      EXPECT_EQ(labellers[0]->state(), labellers[i]->state());
    }
  }
  return frames;
}

TEST(Determinism, SameBytesForOneTwoAndFourThreads) {
  const char* folder = std::getenv("EGOSIEVE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
  const int pool = cv::getNumThreads();
  for (const std::string& input : Inputs()) {
    int64_t frames = 0;
    for (const auto& options : {FrameLabellerOptions(), FrameLabellerOptions::Paper()}) {
      frames = CompareThreads(absl::StrCat(folder, "/", input), options);
      EXPECT_GE(frames, 3) << input;
    }
    std::printf("%-34s %lld frames\n", input.c_str(), static_cast<long long>(frames));
  }
  cv::setNumThreads(pool);
}

}  // namespace
}  // namespace egosieve::vision
