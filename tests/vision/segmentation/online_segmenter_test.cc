#include "vision/segmentation/online_segmenter.h"

#include <memory>
#include <vector>

#include "kernels/runtime/context.h"
#include "tests/testing/status.h"
#include "tests/vision/segmentation/moving_square.h"

namespace egosieve::vision {
namespace {

class OnlineSegmenterTest : public testing::Test {
 protected:
  static std::unique_ptr<OnlineSegmenter> MakeSegmenter(OnlineSegmenterOptions options) {
    options.learner.training.annealing_evaluations = 20;
    auto context = Value(kernels::OpenContext());
    return Value(OnlineSegmenter::Create(context, options));
  }

  OnlineSegmenter::Result Process(OnlineSegmenter& segmenter, const Frame& frame) {
    return Value(segmenter.Process(frame));
  }

  // The share of pairs (pixel of the square, other pixel) that the map orders rightly.
  double Auc(const SegmentationMap& map) const {
    const cv::Rect square = drive_.Square(map.frame_index);
    std::vector<float> inside, outside;
    for (int row = 0; row < map.grid.rows(); ++row) {
      for (int column = 0; column < map.grid.columns(); ++column) {
        const cv::Point pixel(map.grid.x_pixels(column), map.grid.y_pixels(row));
        (square.contains(pixel) ? inside : outside)
            .push_back(map.probability[row * map.grid.columns() + column]);
      }
    }
    double ordered = 0.0;
    for (const float a : inside) {
      for (const float b : outside) {
        ordered += a > b ? 1.0 : a == b ? 0.5 : 0.0;
      }
    }
    return ordered / (static_cast<double>(inside.size()) * static_cast<double>(outside.size()));
  }

  MovingSquare drive_;
};

TEST_F(OnlineSegmenterTest, FirstFrameGetsThePrior) {
  for (const auto& options : {OnlineSegmenterOptions::Default(), OnlineSegmenterOptions::Fast()}) {
    auto segmenter = MakeSegmenter(options);
    const auto result = Process(*segmenter, drive_.At(0));
    EXPECT_FALSE(result.record.learnt);
    EXPECT_FALSE(result.record.reason.empty());
    EXPECT_EQ(result.record.model_size, 0);
    ASSERT_EQ(static_cast<int64_t>(result.map.probability.size()), result.map.grid.size());
    for (const float probability : result.map.probability) {
      ASSERT_FLOAT_EQ(probability, 0.5f);
    }
    for (const float deviation : result.map.deviation) {
      ASSERT_GT(deviation, 0.0f);
    }
  }
}

TEST_F(OnlineSegmenterTest, FindsWhatMovesInEveryProfile) {
  for (const auto& options : {OnlineSegmenterOptions::Default(), OnlineSegmenterOptions::Paper(),
                              OnlineSegmenterOptions::Fast()}) {
    auto segmenter = MakeSegmenter(options);
    double auc = 0.0;
    for (int64_t index = 0; index < 6; ++index) {
      const auto result = Process(*segmenter, drive_.At(index));
      EXPECT_EQ(result.record.learnt, index > 0) << result.record.reason;
      auc = Auc(result.map);
    }
    // A wall has no depth, so that the fundamental matrix of the paper's profile is free to explain
    // part of the square away; the selected homography is not.
    EXPECT_GT(auc, options.labeller.is_paper ? 0.6 : 0.95);
  }
}

TEST_F(OnlineSegmenterTest, CountsAddUp) {
  auto segmenter = MakeSegmenter(OnlineSegmenterOptions::Paper());
  int64_t size = 0;
  for (int64_t index = 0; index < 5; ++index) {
    const FrameRecord record = Process(*segmenter, drive_.At(index)).record;
    const SelectionCounts& counts = record.selection;
    EXPECT_EQ(counts.candidates, record.static_label_count + record.dynamic_label_count);
    EXPECT_EQ(counts.added,
              counts.candidates - counts.dropped_by_density - counts.dropped_by_novelty);
    size += counts.added - counts.dropped_by_consistency - counts.dropped_by_model_density -
            counts.dropped_by_age - counts.dropped_by_budget;
    EXPECT_EQ(record.model_size, size);
  }
  EXPECT_GT(size, 0);
}

TEST_F(OnlineSegmenterTest, StaysWithinItsBudget) {
  OnlineSegmenterOptions options = OnlineSegmenterOptions::Default();
  options.learner.budget.budget = 150;
  auto segmenter = MakeSegmenter(options);
  int64_t dropped = 0;
  for (int64_t index = 0; index < 4; ++index) {
    const FrameRecord record = Process(*segmenter, drive_.At(index)).record;
    EXPECT_LE(record.model_size, 150);
    dropped += record.selection.dropped_by_budget;
  }
  EXPECT_GT(dropped, 0);
}

TEST_F(OnlineSegmenterTest, SameSeedSameBytes) {
  for (const auto& profile : {OnlineSegmenterOptions::Default(), OnlineSegmenterOptions::Fast()}) {
    std::vector<float> first;
    for (int repetition = 0; repetition < 2; ++repetition) {
      OnlineSegmenterOptions options = profile;
      options.SetSeed(9);
      options.labeller.threads = 1 + 2 * repetition;
      auto segmenter = MakeSegmenter(options);
      std::vector<float> all;
      for (int64_t index = 0; index < 4; ++index) {
        const auto result = Process(*segmenter, drive_.At(index));
        all.insert(all.end(), result.map.probability.begin(), result.map.probability.end());
        all.insert(all.end(), result.map.deviation.begin(), result.map.deviation.end());
      }
      if (repetition == 0) {
        first = all;
      } else {
        EXPECT_EQ(all, first);
      }
    }
  }
}

TEST_F(OnlineSegmenterTest, AFrameThatTeachesNothingGetsAMapFromTheModelAsItIs) {
  auto segmenter = MakeSegmenter(OnlineSegmenterOptions::Default());
  for (int64_t index = 0; index < 3; ++index) {
    Process(*segmenter, drive_.At(index));
  }
  const int64_t size = segmenter->learner().model().size();
  Frame black = drive_.At(3);
  black.image = cv::Mat::zeros(black.image.size(), CV_8UC3);
  const auto dark = Process(*segmenter, black);
  EXPECT_FALSE(dark.record.learnt);
  EXPECT_FALSE(dark.record.reason.empty());
  EXPECT_EQ(dark.record.model_size, size);
  EXPECT_EQ(static_cast<int64_t>(dark.map.probability.size()), dark.map.grid.size());

  Frame larger = drive_.At(4);
  cv::resize(larger.image, larger.image, cv::Size(300, 200));
  const auto resized = Process(*segmenter, larger);
  EXPECT_FALSE(resized.record.learnt);
  EXPECT_FALSE(resized.record.reason.empty());
  EXPECT_EQ(resized.map.grid.width, 300);
}

TEST(OnlineSegmenterOptionsTest, ValidateNamesFieldAndValue) {
  OnlineSegmenterOptions options;
  EXPECT_TRUE(options.Validate().ok());
  options.stride_pixels = 0;
  EXPECT_EQ(options.Validate().message(), "stride_pixels = 0; it must be at least 1");
  options = OnlineSegmenterOptions();
  options.learner.calibration_sample_size = 1;
  EXPECT_THAT(options.Validate(), IsInvalid());
  options = OnlineSegmenterOptions();
  options.learner.model_density.radius = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(options.Validate(), IsInvalid());
}

}  // namespace
}  // namespace egosieve::vision
