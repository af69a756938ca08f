// What must hold of every drive that goes through the labeller: what is not the world takes no part
// in the labels, labels of reduced pictures are in the pixels of the whole ones, each stage that ran
// says so in its time, pairs that are prepared ahead change nothing, and the speed of the ground is
// that of the camera, where there are no pictures ahead, too.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>
#include <vector>

#include "tests/testing/status.h"
#include "tests/vision/labelling/same_labels.h"
#include "tests/vision/labelling/street_drive.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/labelling/flow_cache.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/labeller_state.h"
#include "vision/labelling/reduced_labels.h"
#include "vision/segmentation/labeller_factory.h"
#include "vision/synthetic/camera.h"

namespace egosieve::vision {
namespace {

using Pictures = std::vector<std::shared_ptr<const ExtractedFrame>>;
using Clock = std::chrono::steady_clock;
constexpr int kTop = 120;  // of 240 rows; below it a dashboard

// The last frame's labels of a turn behind a dashboard that fills the lower half.
LabelledFrame LabelsOf(bool ignores) {
  const Scenario scenario = EditedScenario("turning", 3, [](Scene&) {});
  FrameLabellerOptions options{.focal_ratio = FocalRatioOf(scenario)};
  if (ignores) {
    options.ignored = cv::Mat1b::zeros(240, 400);
    options.ignored(cv::Rect(0, kTop, 400, 240 - kTop)) = 255;
  }
  const std::vector<DrivePicture> pictures = PicturesOf(scenario, 57, 4);
  const cv::Mat dashboard = pictures[0].frame.image(cv::Rect(0, 60, 400, 240 - kTop)).clone();
  for (const DrivePicture& picture : pictures) {
    dashboard.copyTo(picture.frame.image(cv::Rect(0, kTop, 400, 240 - kTop)));
  }
  return LastLabels(options, pictures);
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

// Seen through a lens that moves the corners of the picture by 40 pixels, movers and the static
// scene are told apart as well as without it, and places are those of the picture.
TEST(LabelledDrives, ALensIsCorrected) {
  const Scenario scenario =
      EditedScenario("junction", 2, [](Scene& scene) { scene.intrinsics.radial = -0.24; });
  const std::vector<DrivePicture> pictures = PicturesOf(scenario, 40, 4);
  const Intrinsics& k = scenario.intrinsics();
  const auto count = [&](bool is_known) {
    Lens lens{k.focal_pixels, k.focal_pixels, k.centre_x + 0.5, k.centre_y + 0.5};
    if (is_known) lens.distortion[0] = k.radial;
    const LensCorrection correction = Value(LensCorrection::Create(lens, {400, 240}));
    FrameLabellerOptions options;
    options.focal_ratio = correction.focal_pixels() / 400;
    options.travel = TravelOf(scenario, 40);
    if (is_known) options.lens = std::make_shared<LensCorrection>(correction);
    const LabelledFrame labels = LastLabels(options, pictures);
    EXPECT_GT(labels.size(), 1000);
    const int stride = FrameLabellerOptions::kFlowStridePixels;
    double farthest = 0.0;  // of a label's ray from a node of the pinhole picture's grid
    for (int64_t i = 0; is_known && i < labels.size(); ++i) {
      const Eigen::Vector2d ray = k.Undistort(labels.positions[2 * i], labels.positions[2 * i + 1]);
      const Eigen::Vector2d node =
          correction.focal_pixels() * ray + Eigen::Vector2d(199.5 - stride / 2, 119.5 - stride / 2);
      farthest = std::max({farthest, std::abs(std::remainder(node(0), stride)),
                           std::abs(std::remainder(node(1), stride))});
    }
    EXPECT_LT(farthest, 1e-3);
    return Count(labels, pictures.back().movers);
  };
  const LabelCounts known = count(true), unknown = count(false);
  EXPECT_GT(known.FoundShare(), 0.7);
  EXPECT_LT(known.FalseShare(), 0.03);
  EXPECT_LT(known.FalseShare(), 0.75 * unknown.FalseShare());
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
  FrameLabellerOptions options{.focal_ratio = FocalRatioOf(scenario)};
  const cv::Rect reflection(100, 80, 120, 90);
  const auto count_in = [&](const FrameLabellerOptions& with) {
    const LabelledFrame labels = LastLabels(with, PicturesOf(scenario, 57, 4));
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

// As a time stamp in the picture of a moving vehicle, which the static world does not explain.
TEST(FixedPattern, WhatAgreesWithItDoesNotMove) {
  const Scenario scenario = EditedScenario("turning", 3, [](Scene&) {});
  FrameLabellerOptions options{.focal_ratio = FocalRatioOf(scenario),
                               .travel = TravelOf(scenario, 57)};
  std::vector<DrivePicture> pictures = PicturesOf(scenario, 57, 4);
  const cv::Rect overlay(150, 5, 110, 70), inside(160, 15, 90, 50);
  cv::Mat texture(overlay.size(), CV_8UC3);
  cv::RNG random(5);
  random.fill(texture, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(texture, texture, {0, 0}, 2.0);
  for (DrivePicture& picture : pictures) texture.copyTo(picture.frame.image(overlay));
  const auto count_moving = [&] {
    const LabelledFrame labels = LastLabels(options, pictures);
    EXPECT_GT(labels.probability.size(), 1000u);
    int moving = 0;
    for (size_t i = 0; i < labels.probability.size(); ++i) {
      const cv::Point2d place(labels.positions[2 * i], labels.positions[2 * i + 1]);
      moving += labels.probability[i] > 0.5 && cv::Rect2d(inside).contains(place);
    }
    return moving;
  };
  EXPECT_GT(count_moving(), 5);
  options.fixed_pattern = cv::Mat1b::zeros(240, 400);
  cv::Mat grey;
  cv::cvtColor(texture, grey, cv::COLOR_BGR2GRAY);
  grey.copyTo(options.fixed_pattern(overlay));
  EXPECT_EQ(count_moving(), 0);
}

constexpr int kSide = 200;  // of pictures of 400 x 240

TEST(ReducedLabels, PlacesAreThoseOfTheWholePicture) {
  const cv::Size full(1241, 376), reduced = ReducedSize(full, 640);
  EXPECT_EQ(reduced, cv::Size(640, 194));
  LabelledFrame labels{.positions = {0.0, 100.0, 639.0, 100.0},
                       .other_positions = {0.0, 100.0, 639.0, 100.0},
                       .probability = {0.0, 0.0}};
  labels.noise_pixels = 1.0;
  EnlargeLabels(reduced, full, labels);
  // The middle of the first pixel, and that of the last.
  EXPECT_NEAR(labels.positions[0], 0.5 * 1241 / 640 - 0.5, 1e-9);
  EXPECT_NEAR(labels.positions[2], 1240.5 - 0.5 * 1241 / 640, 1e-9);
  EXPECT_EQ(labels.other_positions, labels.positions);
  EXPECT_NEAR(labels.noise_pixels, 1.939, 1e-3);
}

TEST(ReducedLabels, CoverTheWholePicture) {
  const Scenario scenario = EditedScenario("turning", 3, [](Scene&) {});
  FrameLabellerOptions options{.focal_ratio = FocalRatioOf(scenario),
                               .ignored = cv::Mat1b::zeros(240, 400)};
  options.ignored(cv::Rect(0, 180, 400, 60)) = 255;
  int64_t whole_size = 0;
  for (const int side : {0, kSide}) {
    options.longest_side_pixels = side;
    const LabelledFrame labels = LastLabels(options, PicturesOf(scenario, 57, 4));
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

TEST(StageTimes, EveryStageThatRanHasOne) {
  for (const FrameLabellerOptions& options :
       {FrameLabellerOptions(), FrameLabellerOptions::Paper()}) {
    auto labeller = *MakeFrameLabeller(options);
    for (int64_t index = 0; index < 3; ++index) {
      const Frame frame = WallFrame(index);
      // Features are computed ahead of the labels, as in a drive.
      const Clock::time_point begin = Clock::now();
      const auto extracted = Value(labeller->Extract(frame));
      const auto labelled = Value(labeller->Label(extracted));
      const std::chrono::duration<double, std::milli> whole = Clock::now() - begin;
      if (index == 0) continue;
      EXPECT_EQ(labelled.outcome, LabelOutcome::kLabelled) << labelled.reason;
      const StageMilliseconds& milliseconds = labelled.milliseconds;
      EXPECT_GT(milliseconds.equalization, 0.0);
      EXPECT_GT(milliseconds.features, 0.0) << options.is_paper;
      EXPECT_GT(milliseconds.matching, 0.0) << options.is_paper;
      EXPECT_GT(milliseconds.geometry, 0.0);
      EXPECT_GT(milliseconds.labelling, 0.0);
      // Stages follow each other: counted twice, or in another unit, they would exceed the call. Of
      // what the call does they are nearly all.
      const double sum = milliseconds.equalization + milliseconds.features + milliseconds.matching +
                         milliseconds.geometry + milliseconds.labelling;
      EXPECT_LE(sum, whole.count());
      EXPECT_GE(sum, 0.5 * whole.count()) << options.is_paper;
    }
  }
}

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
  const FrameLabellerOptions options{.focal_ratio = 0.65};
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
      double least = frames[1].milliseconds.features;
      for (size_t t = 1; t + kAhead < frames.size(); ++t) {
        least = std::min(least, frames[t].milliseconds.features);
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

constexpr int kFirst = 20, kCount = 20;
constexpr double kPicturesPerSecond = 10.0;

TEST(CausalGround, ItsSpeedIsThatOfTheCamera) {
  const Scenario scenario = EditedScenario("street", 3, [](Scene&) {});
  FrameLabellerOptions options;
  options.frame_gap = 0;  // by parallax
  options.focal_ratio = FocalRatioOf(scenario);
  options.travel = TravelOf(scenario, kFirst);
  const auto labeller = MakeLabeller(options);
  for (const DrivePicture& picture : PicturesOf(scenario, kFirst, kCount)) {
    ASSERT_TRUE(labeller->Process(picture.frame).ok());
    const auto k = static_cast<int>(picture.frame.index);
    GroundSpeed speed;
    ASSERT_TRUE(speed.Restore(FromBytes(labeller->state())->ground));
    const double truth = (scenario.PoseAt(k + 1).centre - scenario.PoseAt(k).centre).norm() *
                         kPicturesPerSecond / scenario.PoseAt(k).centre.z();
    EXPECT_LT(speed.Low(), 1.1 * truth) << k;
    if (k >= kFirst + kCount / 2) {
      EXPECT_GT(speed.Low(), 0.7 * truth) << k;
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
