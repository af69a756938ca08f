// Videos that a drive can meet: every frame has an outcome and, where there are no labels, a
// reason.
#include <cstdint>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tests/vision/labelling/feature_evaluation.h"
#include "tests/vision/labelling/same_labels.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

const cv::Size kSize(320, 192);

struct Mover {
  cv::Rect at;  // at time 0
  int speed;    // pixels a frame, to the right
};

// A wall that slides to the left by `pan` pixels a frame, and squares in front of it.
class Scene {
 public:
  Scene(int pan, std::vector<Mover> movers) : pan_(pan), movers_(std::move(movers)) {}

  cv::Mat Image(double time) const {
    cv::Mat image =
        wall_(cv::Rect(static_cast<int>(pan_ * time), 0, kSize.width, kSize.height)).clone();
    for (size_t i = 0; i < movers_.size(); ++i) {
      const cv::Rect at = Place(movers_[i], time);
      Texture(at.width, at.height, 90 + i).copyTo(image(at));
    }
    return image;
  }

  cv::Mat Mask(double time) const {
    cv::Mat mask = cv::Mat::zeros(kSize.height, kSize.width, CV_8UC1);
    for (const Mover& mover : movers_) mask(Place(mover, time)).setTo(255);
    return mask;
  }

 private:
  static cv::Rect Place(const Mover& mover, double time) {
    return mover.at + cv::Point(static_cast<int>(mover.speed * time), 0);
  }

  int pan_;
  std::vector<Mover> movers_;
  cv::Mat wall_ = Texture(3 * kSize.width, kSize.height, 5);
};

class DifficultVideo : public ::testing::Test {
 protected:
  // Through the coder and back, frame by frame through the labeller.
  std::vector<LabelledFrame> LabelVideo(int count, const std::function<cv::Mat(int)>& image,
                                        const char (&codec)[5] = "FFV1") {
    const std::string path = folder_ + "/v.avi";
    {
      const int four = cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]);
      cv::VideoWriter writer(path, cv::CAP_FFMPEG, four, 25, kSize);
      EXPECT_TRUE(writer.isOpened());
      for (int t = 0; t < count; ++t) writer.write(image(t));
    }
    std::vector<LabelledFrame> frames;
    auto source = Value(OpenFrameSource(path));
    auto labeller = *MakeFrameLabeller({});
    while (true) {
      const auto read = Value(source->Next());
      if (!std::holds_alternative<Frame>(read)) break;
      frames.push_back(Value(labeller->Process(std::get<Frame>(read))));
      const LabelledFrame& labelled = frames.back();
      EXPECT_EQ(labelled.outcome == LabelOutcome::kLabelled, labelled.reason.empty())
          << labelled.reason;
      EXPECT_EQ(labelled.outcome == LabelOutcome::kLabelled, labelled.size() > 0);
    }
    EXPECT_EQ(static_cast<int>(frames.size()), count);
    return frames;
  }

  const std::string folder_ = FreshFolder();
};

// A coder that loses something makes the first frames differ: a camera that stands, and nothing
// moves.
TEST_F(DifficultVideo, OneRepeatedFrameWithCodingNoise) {
  const Scene scene(0, {});
  const std::vector<LabelledFrame> frames = LabelVideo(
      4, [&](int) { return scene.Image(0); }, "MJPG");
  for (size_t t = 1; t < frames.size(); ++t) {
    if (frames[t].outcome == LabelOutcome::kDuplicateFrame) continue;
    EXPECT_EQ(frames[t].outcome, LabelOutcome::kLabelled) << frames[t].reason;
    EXPECT_EQ(frames[t].motion_model, MotionModelKind::kStatic);
    for (const double p : frames[t].probability) ASSERT_LT(p, 0.5);
  }
}

// Each picture is shown twice, as in film that was sped up: every second pair is a duplicate, and
// the others are labelled.
TEST_F(DifficultVideo, EveryFrameTwice) {
  const Scene scene(3, {{{60, 70, 60, 50}, 4}});
  const std::vector<LabelledFrame> frames =
      LabelVideo(8, [&](int t) { return scene.Image(t / 2); });
  for (size_t t = 1; t < frames.size(); ++t) {
    EXPECT_EQ(frames[t].outcome,
              t % 2 == 1 ? LabelOutcome::kDuplicateFrame : LabelOutcome::kLabelled)
        << t << ": " << frames[t].reason;
  }
}

TEST_F(DifficultVideo, LensCapForThreeFrames) {
  const Scene scene(3, {{{60, 70, 60, 50}, 4}});
  const auto is_capped = [](int t) { return t >= 3 && t < 6; };
  const std::vector<LabelledFrame> frames = LabelVideo(9, [&](int t) {
    if (!is_capped(t)) return scene.Image(t);
    cv::Mat dark(kSize.height, kSize.width, CV_8UC3);
    cv::RNG(t).fill(dark, cv::RNG::NORMAL, 4, 1);  // a sensor's noise
    return dark;
  });
  for (int t = 1; t < static_cast<int>(frames.size()); ++t) {
    const bool pair_is_seen = !is_capped(t) && !is_capped(t - 1);
    EXPECT_EQ(frames[t].outcome == LabelOutcome::kLabelled, pair_is_seen)
        << t << ": " << static_cast<int>(frames[t].outcome) << " " << frames[t].reason;
  }
}

// Odd rows are half a frame later. The camera pans and a square goes the other way.
TEST_F(DifficultVideo, Interlaced) {
  const Scene scene(4, {{{40, 60, 70, 60}, 4}});
  const std::vector<LabelledFrame> frames = LabelVideo(6, [&](int t) {
    cv::Mat image = scene.Image(t);
    const cv::Mat later = scene.Image(t + 0.5);
    for (int y = 1; y < image.rows; y += 2) later.row(y).copyTo(image.row(y));
    return image;
  });
  for (size_t t = 1; t < frames.size(); ++t) {
    ASSERT_EQ(frames[t].outcome, LabelOutcome::kLabelled) << frames[t].reason;
    const double time = static_cast<double>(frames[t].labelled.index) + 0.25;
    EXPECT_GT(AreaUnderMask(frames[t], scene.Mask(time)), 0.9) << t;
  }
}

// A fifth of the picture moves, all of it along the rows; the camera does not.
TEST_F(DifficultVideo, StandingCameraAmongMovers) {
  const Scene scene(0, {{{10, 10, 60, 60}, 5}, {{200, 20, 70, 60}, -4}, {{60, 110, 80, 60}, 3}});
  const std::vector<LabelledFrame> frames = LabelVideo(6, [&](int t) { return scene.Image(t); });
  for (size_t t = 1; t < frames.size(); ++t) {
    ASSERT_EQ(frames[t].outcome, LabelOutcome::kLabelled) << frames[t].reason;
    EXPECT_EQ(frames[t].motion_model, MotionModelKind::kStatic);
    const double time = static_cast<double>(frames[t].labelled.index);
    EXPECT_GT(AreaUnderMask(frames[t], scene.Mask(time)), 0.95) << t;
  }
}

// A picture as an uncompressed block of GIF: pixels of 7 bits, a clear code before the dictionary
// would make codes longer.
void AppendGifPicture(int side, int value, int delay_hundredths, std::string& bytes) {
  const auto byte = [&](int b) { bytes.push_back(static_cast<char>(b)); };
  const auto word = [&](int w) {
    byte(w & 255);
    byte(w >> 8);
  };
  bytes += std::string("\x21\xf9\x04\x04", 4);
  word(delay_hundredths);
  word(0);
  byte(0x2c);
  word(0), word(0), word(side), word(side), byte(0);
  byte(7);  // bits a pixel; 128 is the clear code, 129 the end
  std::vector<int> codes;
  for (int i = 0; i < side * side; ++i) {
    if (i % 100 == 0) codes.push_back(128);
    codes.push_back((value + i) % 128);
  }
  codes.push_back(129);
  for (size_t begin = 0; begin < codes.size(); begin += 128) {
    // 8-bit codes: a byte each.
    const size_t count = std::min<size_t>(128, codes.size() - begin);
    byte(static_cast<int>(count));
    for (size_t i = begin; i < begin + count; ++i) byte(codes[i]);
  }
  byte(0);
}

// Frames that are shown for different times: time comes from the stream, not from a rate.
TEST_F(DifficultVideo, VariableRate) {
  constexpr int kSide = 64, kDelays[] = {10, 30, 20, 50, 10};
  std::string bytes = "GIF89a";
  for (const int b : {kSide, 0, kSide, 0, 0xf6, 0, 0}) bytes.push_back(static_cast<char>(b));
  for (int i = 0; i < 128; ++i) bytes += std::string(3, static_cast<char>(2 * i));
  for (int k = 0; k < 5; ++k) AppendGifPicture(kSide, 20 * k, kDelays[k], bytes);
  bytes.push_back(0x3b);
  const std::string path = folder_ + "/v.gif";
  std::ofstream(path, std::ios::binary) << bytes;
  auto source = OpenFrameSource(path);
  if (!source.ok()) GTEST_SKIP() << "FFmpeg was built without GIF: " << source.status();
  double expected = 0.0;
  for (const int delay : kDelays) {
    const auto read = (*source)->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
    EXPECT_NEAR(std::get<Frame>(*read).time_seconds, expected, 1e-3);
    expected += delay / 100.0;
  }
}

// Pictures that a labeller cannot learn from, or hardly.

struct HardPair {
  const char* name;
  std::function<cv::Mat(int)> image;  // of frame 0 and 1
  std::vector<LabelOutcome> allowed;
};

cv::Mat Constant(int value) { return cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(value)); }

std::vector<HardPair> StressCases() {
  const LabelOutcome labelled = LabelOutcome::kLabelled, duplicate = LabelOutcome::kDuplicateFrame,
                     features = LabelOutcome::kTooFewFeatures,
                     matches = LabelOutcome::kTooFewMatches,
                     untrusted = LabelOutcome::kUntrustedMotion;
  return {
      {"black", [](int) { return Constant(0); }, {duplicate}},
      {"white, then nearly", [](int t) { return Constant(255 - t); }, {features}},
      {"lens cap",
       [](int t) { return t == 0 ? WallFrame(0).image : Constant(3); },
       {features, matches, untrusted}},
      {"identical", [](int) { return WallFrame(0).image; }, {duplicate}},
      {"noise",
       [](int t) {
         cv::Mat image(kHeight, kWidth, CV_8UC3);
         std::mt19937_64 engine(90 + t);
         for (size_t i = 0; i < image.total() * 3; ++i) {
           image.data[i] = static_cast<uint8_t>(engine());
         }
         return image;
       },
       {matches, untrusted}},
      {"cut", [](int t) { return Texture(kWidth, kHeight, 40 + t); }, {matches, untrusted}},
      {"quarter turn",
       [](int t) {
         cv::Mat image = Texture(kHeight, kHeight, 50), turned;
         if (t == 0) return image;
         cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
         return turned;
       },
       {labelled, matches, untrusted}},
      {"one row of texture",
       [](int t) {
         cv::Mat image = Constant(90);
         Texture(kWidth, 20, 60)(cv::Rect(t, 0, kWidth - 2, 4))
             .copyTo(image(cv::Rect(0, 80, kWidth - 2, 4)));
         return image;
       },
       {labelled, features, matches, untrusted}},
      {"a few dots",
       [](int t) {
         cv::Mat image = Constant(30);
         for (int k = 0; k < 5; ++k)
           cv::circle(image, {30 + 40 * k + t, 40 + 17 * k}, 4, {200, 220, 250}, -1);
         return image;
       },
       {labelled, features, matches, untrusted}},
      {"over-exposed",
       [](int t) { return cv::Mat(WallFrame(t).image * 4 + cv::Scalar::all(180)); },
       {labelled, features, matches, untrusted}},
  };
}

TEST(Stress, GivesADefinedOutcomeAndTheDriveGoesOn) {
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    for (const HardPair& stress : StressCases()) {
      SCOPED_TRACE(::testing::Message() << stress.name << (options.is_paper ? ", paper" : ""));
      auto labeller = MakeLabeller(options);
      ASSERT_TRUE(labeller->Process(FrameOf(0, stress.image(0))).ok());
      const auto labelled = Value(labeller->Process(FrameOf(1, stress.image(1))));
      ExpectWellFormed(labelled);
      if (!options.is_paper || labelled.outcome != LabelOutcome::kTooFewFeatures) {
        EXPECT_THAT(stress.allowed, ::testing::Contains(labelled.outcome))
            << static_cast<int>(labelled.outcome) << ": " << labelled.reason;
      }
    }
  }
}

TEST(Stress, FramesOfAnotherSizeStartAnew) {
  auto labeller = MakeLabeller({});
  ASSERT_TRUE(labeller->Process(WallFrame(0)).ok());
  const auto changed = Value(labeller->Process(FrameOf(1, Texture(100, 90, 1))));
  EXPECT_EQ(changed.outcome, LabelOutcome::kSizeChanged);
  ExpectWellFormed(changed);
  const auto back = labeller->Process(WallFrame(2));
  EXPECT_EQ(back->outcome, LabelOutcome::kSizeChanged);
  EXPECT_EQ(labeller->Process(WallFrame(3))->outcome, LabelOutcome::kLabelled);
}

TEST(Stress, TinyFrames) {
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    for (const int side : {1, 2, 5, 15, 16, 17, 33}) {
      auto labeller = MakeLabeller(options);
      ASSERT_TRUE(labeller->Process(FrameOf(0, Texture(side, side, 1))).ok()) << side;
      const auto labelled = Value(labeller->Process(FrameOf(1, Texture(side, side, 2))));
      ExpectWellFormed(labelled);
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
