// What is not the world takes no part in the labels, but for being static.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "tests/vision/labelling/street_drive.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

constexpr int kTop = 120;  // of 240 rows; below it a dashboard

// The last frame's labels of a turn behind a dashboard that fills the lower half.
LabelledFrame LabelsOf(bool ignores) {
  const Scenario scenario = EditedScenario("turning", 3, [](Scene&) {});
  FrameLabellerOptions options;
  options.focal_ratio = scenario.intrinsics().focal_pixels / scenario.options().width_pixels;
  if (ignores) {
    options.ignored = cv::Mat1b::zeros(240, 400);
    options.ignored(cv::Rect(0, kTop, 400, 240 - kTop)) = 255;
  }
  const std::unique_ptr<FrameLabeller> labeller = *MakeFrameLabeller(options);
  const std::vector<DrivePicture> pictures = PicturesOf(scenario, 57, 4);
  const cv::Mat dashboard = pictures[0].frame.image(cv::Rect(0, 60, 400, 240 - kTop)).clone();
  LabelledFrame labels;
  for (const DrivePicture& picture : pictures) {
    dashboard.copyTo(picture.frame.image(cv::Rect(0, kTop, 400, 240 - kTop)));
    labels = *labeller->Process(picture.frame);
  }
  return labels;
}

double ShareAbove(const LabelledFrame& labels, bool of_dashboard) {
  int count = 0, moving = 0;
  for (size_t i = 0; i < labels.probability.size(); ++i) {
    // The flow near the edge is of both.
    const double y = labels.positions[2 * i + 1];
    if (of_dashboard ? y < kTop : y >= kTop - 16) continue;
    ++count;
    moving += labels.probability[i] > 0.5;
  }
  EXPECT_GT(count, 100);
  return static_cast<double>(moving) / std::max(count, 1);
}

TEST(IgnoredArea, IsStaticAndHasNoPartInTheMotion) {
  const LabelledFrame labels = LabelsOf(true);
  ASSERT_EQ(labels.outcome, LabelOutcome::kLabelled);
  EXPECT_EQ(ShareAbove(labels, true), 0.0);
  EXPECT_LT(ShareAbove(labels, false), 0.05);
  // It is half of the picture: taken for the world, it makes the world move.
  const LabelledFrame fooled = LabelsOf(false);
  EXPECT_GT(std::max(ShareAbove(fooled, false), ShareAbove(fooled, true)), 0.3);
}

TEST(Windscreen, HasNoLabels) {
  const Scenario scenario = EditedScenario("turning", 3, [](Scene&) {});
  FrameLabellerOptions options;
  options.focal_ratio = scenario.intrinsics().focal_pixels / scenario.options().width_pixels;
  const cv::Rect reflection(100, 80, 120, 90);
  const auto count_in = [&](const FrameLabellerOptions& with) {
    const std::unique_ptr<FrameLabeller> labeller = *MakeFrameLabeller(with);
    LabelledFrame labels;
    for (const DrivePicture& picture : PicturesOf(scenario, 57, 4)) {
      labels = *labeller->Process(picture.frame);
    }
    int inside = 0;
    for (size_t i = 0; i < labels.probability.size(); ++i) {
      const cv::Point2d place(labels.positions[2 * i], labels.positions[2 * i + 1]);
      inside += cv::Rect2d(reflection).contains(place);
    }
    EXPECT_GT(labels.probability.size(), 1000u);
    return inside;
  };
  EXPECT_GT(count_in(options), 300);
  options.windscreen = cv::Mat1b::zeros(240, 400);
  options.windscreen(reflection) = 255;
  // But for those that the static world explains where flow is lost.
  EXPECT_LT(count_in(options), 30);
}

}  // namespace
}  // namespace egosieve::vision
