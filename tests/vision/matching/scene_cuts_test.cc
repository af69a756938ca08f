// Videos put together from slides over textures: a cut is found where the texture changes, and
// nowhere else.
#include "vision/matching/scene_cuts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "absl/status/status.h"
#include "tests/vision/features/textured_image.h"

namespace egosieve::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Pictures in memory; an empty one is damaged.
class Pictures : public FrameSource {
 public:
  explicit Pictures(std::vector<cv::Mat> grey) : grey_(std::move(grey)) {}

  absl::StatusOr<FrameRead> Next() override {
    if (next_ == static_cast<int64_t>(grey_.size())) return EndOfFrames{next_, "", 0.0};
    const int64_t index = next_++;
    if (grey_[index].empty()) return DamagedFrame{index, "damaged"};
    Frame frame;
    frame.index = index;
    cv::cvtColor(grey_[index], frame.image, cv::COLOR_GRAY2BGR);
    return frame;
  }
  absl::Status SeekTo(int64_t index) override {
    next_ = index;
    return absl::OkStatus();
  }
  int64_t next_index() const override { return next_; }
  int64_t expected_frame_count() const override { return -1; }
  std::string description() const override { return "pictures"; }

 private:
  std::vector<cv::Mat> grey_;
  int64_t next_ = 0;
};

// `count` views that slide 4 pixels a frame over the texture of that seed.
std::vector<cv::Mat> Slide(uint64_t seed, int count, int width = 320) {
  const cv::Mat texture = testing::TexturedImage(width + 4 * count, width / 2, seed);
  std::vector<cv::Mat> views;
  for (int i = 0; i < count; ++i) views.push_back(texture(cv::Rect(4 * i, 0, width, width / 2)));
  return views;
}

std::vector<int64_t> CutsOf(std::vector<std::vector<cv::Mat>> scenes) {
  std::vector<cv::Mat> all;
  for (const auto& scene : scenes) all.insert(all.end(), scene.begin(), scene.end());
  const int64_t count = static_cast<int64_t>(all.size());
  Pictures source(std::move(all));
  const absl::StatusOr<SceneCuts> found = FindSceneCuts(source);
  EXPECT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->frames, count);
  return found->cuts;
}

TEST(SceneCuts, LieWhereAnotherSceneBegins) {
  EXPECT_THAT(CutsOf({Slide(1, 8)}), IsEmpty());
  EXPECT_THAT(CutsOf({Slide(1, 8), Slide(2, 6), Slide(3, 5)}), ElementsAre(8, 14));
  EXPECT_THAT(CutsOf({Slide(1, 4, 800), Slide(2, 4, 800)}), ElementsAre(4)) << "reduced pictures";
  EXPECT_THAT(CutsOf({Slide(1, 1), Slide(2, 4)}), ElementsAre(1));
  EXPECT_THAT(CutsOf({Slide(1, 4), Slide(2, 1)}), ElementsAre(4));
  EXPECT_THAT(CutsOf({}), IsEmpty());
}

// White, as when a light flashes; and a picture that cannot be read.
TEST(SceneCuts, AFlashIsNone) {
  std::vector<cv::Mat> flashed = Slide(1, 9);
  flashed[4] = cv::Mat(flashed[4].size(), CV_8UC1, cv::Scalar(250));
  EXPECT_THAT(CutsOf({flashed}), IsEmpty());
  flashed[4] = cv::Mat();
  EXPECT_THAT(CutsOf({flashed}), IsEmpty());
}

TEST(SceneCuts, EndWhenAsked) {
  Pictures source(Slide(1, 5));
  int asked = 0;
  EXPECT_EQ(FindSceneCuts(source, [&] { return ++asked < 3; }).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(source.next_index(), 2);
}

}  // namespace
}  // namespace egosieve::vision
