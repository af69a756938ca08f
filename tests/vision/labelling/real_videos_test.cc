// Two videos joined: the frame behind the cut has no labels but a reason, nothing reaches across,
// and what follows is labelled again. And no such frame in videos without a cut.
#include <climits>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/parallel_for.h"
#include "tests/testing/status.h"
#include "tests/vision/labelling/same_labels.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/labeller_factory.h"
#include "vision/synthetic/street.h"

namespace egosieve::vision {
namespace {

// The suite takes the first frames of the real sequences; with EGOSIEVE_EVERY_FRAME in the
// environment tests take all, for many minutes.
bool AllFrames() { return std::getenv("EGOSIEVE_EVERY_FRAME") != nullptr; }

std::vector<std::string> RealInputs() {
  return {"davis/car-shadow/frames",        "davis/horsejump-high/frames",
          "davis/bmx-trees/frames",         "davis/cows/frames",
          "kt3dmoseg/Seq005_Clip01/frames", "kt3dmoseg/Seq013_Clip02/frames",
          "kt3dmoseg/Seq028_Clip01/frames", "kitti-residential/frames",
          "highway/solidWhiteRight.mp4",    "highway/vehicle_test_video.mp4"};
}

constexpr int kPictures = 3;  // on each side of a cut

struct Clip {
  std::string name;
  std::vector<cv::Mat> images;
};

// Noise blurred by `sigma` pixels: the smoother, the better dense flow pulls one over another.
Clip SmoothClip(double sigma, uint64_t seed) {
  cv::Mat noise(kHeight, kWidth + 40, CV_32FC3), wall;
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::GaussianBlur(noise, noise, {}, sigma);
  cv::Scalar mean, deviation;
  cv::meanStdDev(noise, mean, deviation);
  noise.convertTo(wall, CV_8UC3, 40 / deviation[0], 128 - 40 * mean[0] / deviation[0]);
  Clip clip{absl::StrCat("sigma ", sigma, ", seed ", seed), {}};
  for (int t = 0; t < kPictures; ++t) {
    clip.images.push_back(wall(cv::Rect(4 * t, 0, kWidth, kHeight)).clone());
  }
  return clip;
}

// Another seed is another town; two scenarios of one would show the same street.
Clip StreetClip(const std::string& scenario, uint64_t seed) {
  const ScenarioOptions options{.width_pixels = 400, .height_pixels = 240};
  Clip clip{scenario, {}};
  const Scenario street = Value(MakeScenario(scenario, seed, options));
  for (int t = 0; t < kPictures; ++t) clip.images.push_back(street.Render(20 + t)->image);
  return clip;
}

Clip ReadClip(const std::string& folder, const std::string& input, int most) {
  Clip clip{input, {}};
  auto source = Value(OpenFrameSource(folder + "/" + input));
  while (static_cast<int>(clip.images.size()) < most) {
    const auto read = Value(source->Next());
    if (!std::holds_alternative<Frame>(read)) break;
    clip.images.push_back(std::get<Frame>(read).image.clone());
  }
  return clip;
}

// Both clips of kPictures.
void ExpectCut(const Clip& before, const Clip& after, const FrameLabellerOptions& options) {
  SCOPED_TRACE(absl::StrCat(before.name, " -> ", after.name, options.is_paper ? ", paper" : ""));
  ASSERT_EQ(before.images.size(), static_cast<size_t>(kPictures));
  ASSERT_EQ(after.images.size(), static_cast<size_t>(kPictures));
  const auto labeller = MakeLabeller(options);
  for (int t = 0; t < 2 * kPictures; ++t) {
    cv::Mat image = t < kPictures ? before.images[t] : after.images[t - kPictures];
    if (image.size() != before.images[0].size()) {
      cv::resize(image, image, before.images[0].size(), 0, 0, cv::INTER_AREA);
    }
    const auto frame = Value(labeller->Process(FrameOf(t, image)));
    if (t == kPictures) {
      EXPECT_EQ(frame.outcome, LabelOutcome::kTooFewMatches) << frame.reason;
      EXPECT_FALSE(frame.reason.empty());
      EXPECT_EQ(frame.size(), 0);
    } else if (t > 0) {
      EXPECT_EQ(frame.outcome, LabelOutcome::kLabelled) << t << ": " << frame.reason;
      EXPECT_GE(frame.first_index, t < kPictures ? 0 : kPictures);
    }
  }
}

void ExpectCutsBetweenAll(const std::vector<Clip>& clips, const FrameLabellerOptions& options) {
  for (const Clip& before : clips) {
    for (const Clip& after : clips) {
      if (&before != &after) ExpectCut(before, after, options);
    }
  }
}

TEST(Cut, SmoothTexturesAreToldApart) {
  for (const double sigma : {2.0, 3.0, 6.0, 11.0}) {
    for (uint64_t seed = 1; seed < 5; seed += 2) {
      const Clip one = SmoothClip(sigma, seed), other = SmoothClip(sigma, seed + 1);
      ExpectCut(one, other, {});
      ExpectCut(other, one, {});
    }
  }
}

TEST(Cut, SyntheticStreets) {
  const std::vector<Clip> clips = {StreetClip("street", 3), StreetClip("crossing", 4),
                                   SmoothClip(4.0, 9)};
  ExpectCutsBetweenAll(clips, {});
  ExpectCutsBetweenAll(clips, FrameLabellerOptions::Paper());
}

// One car, two streets: the bonnet below, a fifth of the picture and full of texture, goes on.
TEST(Cut, ABonnetThatGoesOnDoesNotHideIt) {
  Clip one = StreetClip("street", 3), other = StreetClip("crossing", 4);
  const cv::Size size = one.images[0].size();
  const cv::Mat bonnet = Texture(size.width, size.height / 5, 8);
  for (Clip* clip : {&one, &other}) {
    for (cv::Mat& image : clip->images) {
      bonnet.copyTo(image.rowRange(size.height - bonnet.rows, size.height));
    }
  }
  for (const FrameLabellerOptions& options :
       {FrameLabellerOptions(), FrameLabellerOptions::Paper()}) {
    ExpectCut(one, other, options);
    ExpectCut(other, one, options);
  }
}

// What carries over from frame to frame must not carry over the cut: a longer pair does not.
TEST(Cut, NoPairReachesAcross) {
  const Clip one = SmoothClip(4.0, 1), other = SmoothClip(4.0, 2);
  const auto labeller = MakeLabeller({.frame_gap = 2});
  std::vector<LabelOutcome> outcomes;
  for (int t = 0; t < 2 * kPictures; ++t) {
    const auto frame = Value(
        labeller->Process(FrameOf(t, t < kPictures ? one.images[t] : other.images[t - kPictures])));
    outcomes.push_back(frame.outcome);
  }
  using enum LabelOutcome;
  EXPECT_EQ(outcomes, (std::vector<LabelOutcome>{kNoPair, kNoPair, kLabelled, kTooFewMatches,
                                                 kNoPair, kLabelled}));
}

TEST(Cut, RealVideosJoined) {
  const char* folder = std::getenv("EGOSIEVE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
  std::vector<Clip> clips;
  for (const std::string& input : RealInputs()) clips.push_back(ReadClip(folder, input, kPictures));
  size_t join = 0;
  for (size_t i = 0; i < clips.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (join++ % (AllFrames() ? 1 : 11) != 0) continue;
      ExpectCut(clips[i], clips[j], {});
      ExpectCut(clips[j], clips[i], FrameLabellerOptions::Paper());
      if (AllFrames()) ExpectCut(clips[j], clips[i], {});
    }
  }
}

TEST(Cut, RealVideosHaveNone) {
  const char* folder = std::getenv("EGOSIEVE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
  for (const std::string& input : RealInputs()) {
    const Clip clip = ReadClip(folder, input, AllFrames() ? INT_MAX : 6);
    const auto labeller = MakeLabeller({});
    for (size_t t = 0; t < clip.images.size(); ++t) {
      const auto frame = Value(labeller->Process(FrameOf(static_cast<int64_t>(t), clip.images[t])));
      EXPECT_EQ(frame.outcome, t == 0 ? LabelOutcome::kNoPair : LabelOutcome::kLabelled)
          << input << ", frame " << t << ": " << frame.reason;
    }
  }
}

// The same bytes on real video with 1, 2 and 4 threads, our own and OpenCV's.

// Two sequences are enough of the first frames.
std::vector<std::string> Inputs() {
  if (AllFrames()) return RealInputs();
  return {"davis/bmx-trees/frames", "kt3dmoseg/Seq013_Clip02/frames"};
}

// Labellers of 1, 2 and 4 threads, frame by frame side by side. Returns the frames compared.
int64_t CompareThreads(const std::string& input, const FrameLabellerOptions& options) {
  constexpr int kThreads[] = {1, 2, 4};
  std::vector<std::unique_ptr<FrameLabeller>> labellers;
  while (labellers.size() < std::size(kThreads)) labellers.push_back(*MakeFrameLabeller(options));
  auto source = Value(OpenFrameSource(input));
  int64_t frames = 0;
  while ((frames < 3 || AllFrames()) && !::testing::Test::HasFailure()) {
    const auto read = Value(source->Next());
    if (!std::holds_alternative<Frame>(read)) break;
    ++frames;
    LabelledFrame reference;
    for (size_t i = 0; i < labellers.size(); ++i) {
      cv::setNumThreads(kThreads[i]);
      kernels::SetMaximumThreads(kThreads[i]);
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
