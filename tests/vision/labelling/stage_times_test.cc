// Each stage that ran says so in its time, wherever and whenever its work was done.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

using Clock = std::chrono::steady_clock;

// Blurred noise that slides by two pixels a frame.
Frame SlidingNoise(int64_t index) {
  constexpr int kWidth = 320, kHeight = 160;
  cv::Mat noise(kHeight, kWidth + 20, CV_8UC3);
  cv::RNG random(7);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, cv::Size(), 1.5);
  cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
  Frame frame;
  frame.image = noise(cv::Rect(static_cast<int>(2 * index), 0, kWidth, kHeight)).clone();
  frame.index = index;
  return frame;
}

TEST(StageTimes, EveryStageThatRanHasOne) {
  for (const FrameLabellerOptions& options :
       {FrameLabellerOptions(), FrameLabellerOptions::Paper()}) {
    auto labeller = *MakeFrameLabeller(options);
    for (int64_t index = 0; index < 3; ++index) {
      const Frame frame = SlidingNoise(index);
      // Features are computed ahead of the labels, as in a drive.
      const Clock::time_point begin = Clock::now();
      const auto extracted = labeller->Extract(frame);
      ASSERT_TRUE(extracted.ok()) << extracted.status();
      const auto labelled = labeller->Label(*extracted);
      ASSERT_TRUE(labelled.ok()) << labelled.status();
      const std::chrono::duration<double, std::milli> whole = Clock::now() - begin;
      if (index == 0) continue;
      EXPECT_EQ(labelled->outcome, LabelOutcome::kLabelled) << labelled->reason;
      const LabellingTimes& times = labelled->times;
      EXPECT_GT(times.equalization_milliseconds, 0.0);
      EXPECT_GT(times.features_milliseconds, 0.0) << options.is_paper;
      EXPECT_GT(times.matching_milliseconds, 0.0) << options.is_paper;
      EXPECT_GT(times.geometry_milliseconds, 0.0);
      EXPECT_GT(times.labelling_milliseconds, 0.0);
      // Stages follow each other: counted twice, or in another unit, they would exceed the call. Of
      // what the call does they are nearly all.
      const double sum = times.equalization_milliseconds + times.features_milliseconds +
                         times.matching_milliseconds + times.geometry_milliseconds +
                         times.labelling_milliseconds;
      EXPECT_LE(sum, whole.count());
      EXPECT_GE(sum, 0.5 * whole.count()) << options.is_paper;
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
