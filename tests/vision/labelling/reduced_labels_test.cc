// Labels that were made on reduced pictures are in the pixels of the whole ones.
#include "vision/labelling/reduced_labels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "tests/vision/labelling/street_drive.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

constexpr int kSide = 200;  // of pictures of 400 x 240

cv::Vec3d Homogeneous(const std::vector<double>& places, size_t i) {
  return {places[2 * i], places[2 * i + 1], 1.0};
}

TEST(ReducedLabels, MatricesGoOnFitting) {
  const cv::Size full(1241, 376), reduced = ReducedSize(full, 640);
  EXPECT_EQ(reduced, cv::Size(640, 194));
  const cv::Matx33d h(1.01, 0.02, 3.0, -0.01, 0.98, -2.0, 1e-5, -2e-5, 1.0);
  const cv::Vec3d epipole(300.0, 90.0, 1.0);
  const cv::Matx33d across(0.0, -epipole[2], epipole[1], epipole[2], 0.0, -epipole[0], -epipole[1],
                           epipole[0], 0.0);
  LabelledFrame labels;
  labels.motion_model = MotionModelKind::kHomography;
  labels.motion_matrix = h;
  labels.rejected_model = MotionModelKind::kFundamental;
  labels.rejected_matrix = across * h;
  for (const double x : {0.0, 310.0, 639.0}) {
    const cv::Vec3d there = h * cv::Vec3d(x, 100.0, 1.0);
    labels.positions.insert(labels.positions.end(), {x, 100.0});
    labels.other_positions.insert(labels.other_positions.end(),
                                  {there[0] / there[2], there[1] / there[2]});
    labels.probability.push_back(0.0);
  }
  labels.residual_pixels.assign(3, 1.0);
  EnlargeLabels(reduced, full, labels);
  for (size_t i = 0; i < 3; ++i) {
    const cv::Vec3d here = Homogeneous(labels.positions, i);
    const cv::Vec3d there = Homogeneous(labels.other_positions, i);
    cv::Vec3d moved = labels.motion_matrix * here;
    moved /= moved[2];
    EXPECT_NEAR(cv::norm(moved - there), 0.0, 1e-9);
    const cv::Vec3d line = labels.rejected_matrix * here;
    EXPECT_NEAR(line.dot(there) / std::hypot(line[0], line[1]), 0.0, 1e-9);
  }
  // The middle of the first pixel, and that of the last.
  EXPECT_NEAR(labels.positions[0], 0.5 * 1241 / 640 - 0.5, 1e-9);
  EXPECT_NEAR(labels.positions[4], 1240.5 - 0.5 * 1241 / 640, 1e-9);
  EXPECT_NEAR(labels.residual_pixels[0], 1.939, 1e-3);
}

TEST(ReducedLabels, CoverTheWholePicture) {
  const Scenario scenario = EditedScenario("turning", 3, [](Scene&) {});
  FrameLabellerOptions options;
  options.focal_ratio = scenario.intrinsics().focal_pixels / scenario.options().width_pixels;
  options.ignored = cv::Mat1b::zeros(240, 400);
  options.ignored(cv::Rect(0, 180, 400, 60)) = 255;
  int64_t whole_size = 0;
  for (const int side : {0, kSide}) {
    options.longest_side_pixels = side;
    const std::unique_ptr<FrameLabeller> labeller = *MakeFrameLabeller(options);
    LabelledFrame labels;
    for (const DrivePicture& picture : PicturesOf(scenario, 57, 4)) {
      labels = *labeller->Process(picture.frame);
    }
    ASSERT_EQ(labels.outcome, LabelOutcome::kLabelled) << labels.reason;
    EXPECT_EQ(labels.labelled.image.size(), cv::Size(400, 240));
    double right = 0.0, bottom = 0.0;
    for (size_t i = 0; i < labels.probability.size(); ++i) {
      right = std::max(right, labels.positions[2 * i]);
      bottom = std::max(bottom, labels.positions[2 * i + 1]);
      if (labels.positions[2 * i + 1] > 182.0) {
        EXPECT_EQ(labels.probability[i], 0.0);
      }
    }
    EXPECT_GT(right, 380.0);
    EXPECT_GT(bottom, 220.0);
    if (side == 0) whole_size = labels.size();
    // A quarter of the area has a quarter of the nodes.
    if (side > 0) {
      EXPECT_LT(labels.size(), whole_size / 3);
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
