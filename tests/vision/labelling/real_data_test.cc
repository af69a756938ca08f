// Labels on real video against hand-made truth (data/README.md of the data folder names the
// sources: DAVIS 2016, Perazzi et al., CVPR 2016; KT3DMoSeg, Xu, Cheong and Li, CVPR 2018, on KITTI
// raw).
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_format.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/feature_evaluation.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {
namespace {

constexpr int kPairStep = 6;  // every sixth pair of a hand-held sequence: enough for a mean

struct Means {
  double residual = 0.0, label = 0.0;
  int frames = 0, unlabelled = 0, fundamental = 0, homography = 0;
  void Add(const LabelledFrame& frame, const FeatureScore& score) {
    fundamental += frame.motion_model == MotionModelKind::kFundamental;
    homography += frame.motion_model == MotionModelKind::kHomography;
    if (!score.residual_auc.has_value()) return;
    residual += *score.residual_auc;
    label += score.label_auc.value_or(0.0);
    ++frames;
  }
  double residual_mean() const { return residual / frames; }
  double label_mean() const { return label / frames; }
};

class RealData : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("EGOSIEVE_DATA");
    if (folder == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
    data_ = folder;
  }

  std::vector<Frame> ReadFrames(const std::string& folder) {
    std::vector<Frame> frames;
    auto source = OpenFrameSource(folder);
    EXPECT_TRUE(source.ok()) << source.status();
    if (!source.ok()) return frames;
    while (true) {
      const auto read = (*source)->Next();
      if (!read.ok() || !std::holds_alternative<Frame>(*read)) break;
      frames.push_back(std::get<Frame>(*read));
    }
    return frames;
  }

  Means ScoreSequence(const std::string& name, const FrameLabellerOptions& options) {
    Means means;
    const std::vector<Frame> frames = ReadFrames(data_ + "/davis/" + name + "/frames");
    for (size_t t = 1; t < frames.size(); t += kPairStep) {
      auto labeller = FrameLabeller::Create(options);
      EXPECT_TRUE(labeller.ok() && (*labeller)->Prime(frames[t - 1]).ok());
      const auto labelled = (*labeller)->Process(frames[t]);
      EXPECT_TRUE(labelled.ok()) << labelled.status();
      if (!labelled.ok()) continue;
      EXPECT_EQ(labelled->outcome, LabelOutcome::kLabelled) << labelled->reason;
      const cv::Mat mask = cv::imread(
          absl::StrFormat("%s/davis/%s/masks/%05d.png", data_, name, labelled->labelled.index),
          cv::IMREAD_GRAYSCALE);
      EXPECT_FALSE(mask.empty());
      means.Add(*labelled, ScoreAgainstMask(*labelled, mask));
    }
    return means;
  }

  Means ScoreClip(const std::string& name, const FrameLabellerOptions& options) {
    Means means;
    const std::string folder = data_ + "/kt3dmoseg/" + name;
    const std::vector<Frame> frames = ReadFrames(folder + "/frames");
    const auto tracks = ReadLabelledTracks(folder + "/tracks.csv", 1);
    EXPECT_TRUE(tracks.ok()) << tracks.status();
    auto labeller = FrameLabeller::Create(options);
    for (const Frame& frame : frames) {
      const auto labelled = (*labeller)->Process(frame);
      EXPECT_TRUE(labelled.ok()) << labelled.status();
      if (labelled.ok()) means.Add(*labelled, ScoreAgainstTracks(*labelled, *tracks));
    }
    return means;
  }

  std::string data_;
};

void Print(const std::string& name, const Means& means) {
  std::printf("%-16s residual %.3f  label %.3f  frames %3d  F %3d  H %3d\n", name.c_str(),
              means.residual_mean(), means.label_mean(), means.frames, means.fundamental,
              means.homography);
}

// With the default options, on hand-held video: mover against rest.
TEST_F(RealData, HandHeldVideo) {
  for (const char* name : {"car-shadow", "horsejump-high", "bmx-trees", "cows"}) {
    const Means means = ScoreSequence(name, {});
    Print(name, means);
    EXPECT_GE(means.residual_mean(), 0.95) << name;
    EXPECT_GE(means.label_mean(), 0.95) << name;
  }
}

// No clip below what plain OpenCV gives (SIFT, ratio 0.8, RANSAC at 1 pixel; frame gap 1).
TEST_F(RealData, Driving) {
  const std::pair<const char*, double> clips[] = {
      {"Seq005_Clip01", 0.88}, {"Seq013_Clip02", 0.91}, {"Seq028_Clip01", 0.82}};
  for (const auto& [name, plain] : clips) {
    const Means means = ScoreClip(name, {});
    Print(name, means);
    EXPECT_GE(means.residual_mean(), plain) << name;
  }
}

}  // namespace
}  // namespace egosieve::vision
