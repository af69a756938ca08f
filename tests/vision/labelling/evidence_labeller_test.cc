#include "vision/labelling/evidence_labeller.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace egosieve::vision {
namespace {

// Pictures kept for the search for the own vehicle, after one frame.
size_t PicturesKept(const FrameLabellerOptions& options) {
  auto labeller = EvidenceLabeller::Create(options);
  EXPECT_TRUE(labeller.ok()) << labeller.status();
  ExtractedFrame frame;
  frame.grey = cv::Mat(48, 64, CV_8UC1, cv::Scalar(77));
  labeller->Begin(0);
  EXPECT_TRUE(labeller
                  ->Judge(nullptr, frame, 1, MotionModel(), {}, nullptr,
                          Pinhole::Of(frame.grey.size(), 50.0), {})
                  .ok());
  return labeller->own_vehicle().images.size();
}

TEST(EvidenceLabeller, TheFirstPassAloneFindsTheOwnVehicleWhereItSawTheDrive) {
  FrameLabellerOptions options;
  ASSERT_TRUE(options.evidence.own_vehicle);
  EXPECT_EQ(PicturesKept(options), 1u);
  options.fixed_pattern = cv::Mat1b(48, 64, 77);
  EXPECT_EQ(PicturesKept(options), 0u);
}

}  // namespace
}  // namespace egosieve::vision
