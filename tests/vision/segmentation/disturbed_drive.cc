#include "tests/vision/segmentation/disturbed_drive.h"

#include <memory>
#include <opencv2/imgproc.hpp>

#include "kernels/runtime/context.h"
#include "tests/testing/area_under_curve.h"
#include "tests/testing/status.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/synthetic/street.h"

namespace egosieve::vision {
namespace {

constexpr int kFrames = 28;
constexpr int kMiddle = 14;  // the disturbance comes before this frame
constexpr int kScoredFrom = 20;

struct Drive {
  std::vector<cv::Mat> images, masks;
  double focal_ratio = 0.0;
};

const Drive& TheDrive() {
  static const Drive& drive = *[] {
    const ScenarioOptions options{.width_pixels = 256, .height_pixels = 144, .frames = 60};
    const auto scenario = MakeScenario("junction", 1, options);
    auto* drive = new Drive;
    drive->focal_ratio = scenario->intrinsics().focal_pixels / options.width_pixels;
    for (int i = 0; i < kFrames; ++i) {
      SyntheticFrame frame = *scenario->Render(20 + i);
      drive->images.push_back(frame.image);
      drive->masks.push_back(frame.mask);
    }
    return drive;
  }();
  return drive;
}

std::unique_ptr<OnlineSegmenter> MakeSegmenter(DriveProfile profile) {
  OnlineSegmenterOptions options = profile == DriveProfile::kFast
                                       ? OnlineSegmenterOptions::Fast()
                                       : OnlineSegmenterOptions::Default();
  options.labeller.focal_ratio = TheDrive().focal_ratio;
  options.learner.budget.budget = 600;
  options.learner.training.annealing_evaluations = 40;
  options.learner.training.subset_size = 300;
  auto context = Value(kernels::OpenContext());
  return *OnlineSegmenter::Create(context, options);
}

ProcessedFrame Process(OnlineSegmenter& segmenter, int64_t index, const cv::Mat& image) {
  auto result = ProcessFrame(
      segmenter,
      {.index = index, .time_seconds = 0.1 * static_cast<double>(index), .image = image});
  EXPECT_EQ(result.map.grid.width, image.cols);
  EXPECT_EQ(static_cast<int64_t>(result.map.probability.size()), result.map.grid.size());
  EXPECT_NE(result.record.learnt, !result.record.reason.empty());
  for (const float p : result.map.probability) EXPECT_TRUE(p >= 0.0f && p <= 1.0f);
  return result;
}

struct Scores {
  void Add(const SegmentationMap& map, const cv::Mat& mask) {
    for (int row = 0; row < map.grid.rows(); ++row) {
      for (int column = 0; column < map.grid.columns(); ++column) {
        moves.push_back(mask.at<uint8_t>(map.grid.y_pixels(row), map.grid.x_pixels(column)) != 0);
        probability.push_back(map.probability[row * map.grid.columns() + column]);
      }
    }
  }

  std::vector<double> probability;
  std::vector<bool> moves;
};

cv::Mat Resized(const cv::Mat& image, cv::Size size, int interpolation) {
  if (size.empty()) return image;
  cv::Mat resized;
  cv::resize(image, resized, size, 0.0, 0.0, interpolation);
  return resized;
}

// The size holds from the beginning, a disturbance's from behind it.
double Auc(DriveProfile profile, const Disturbance* disturbance, cv::Size size) {
  const std::unique_ptr<OnlineSegmenter> segmenter = MakeSegmenter(profile);
  Scores scores;
  int64_t next_index = 0;
  for (int i = 0; i < kFrames; ++i) {
    if (disturbance != nullptr && i == kMiddle) {
      for (int step = 0; step < disturbance->count; ++step) {
        const ProcessedFrame result =
            Process(*segmenter, next_index++, disturbance->frame(TheDrive().images[i - 1], step));
        EXPECT_FALSE(disturbance->nothing_is_learnt && result.record.learnt) << step;
      }
      size = disturbance->size_after;
      i += disturbance->skipped;
    }
    const ProcessedFrame result =
        Process(*segmenter, next_index++, Resized(TheDrive().images[i], size, cv::INTER_AREA));
    if (i >= kScoredFrom) {
      EXPECT_TRUE(result.record.learnt) << result.record.reason;
      scores.Add(result.map, Resized(TheDrive().masks[i], size, cv::INTER_NEAREST));
    }
  }
  return AreaUnderCurve(scores.probability, scores.moves);
}

}  // namespace

ProcessedFrame ProcessFrame(OnlineSegmenter& segmenter, const Frame& frame) {
  auto learnt = Value(segmenter.Learn(frame, Value(segmenter.labeller().Extract(frame)), true, {}));
  ProcessedFrame result{.record = std::move(learnt.record)};
  result.map = Value(segmenter.Infer(frame, *learnt.posterior, result.record));
  return result;
}

cv::Mat WithNoise(const cv::Mat& image, double deviation, uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat noise(image.size(), CV_16SC3), sum;
  random.fill(noise, cv::RNG::NORMAL, 0.0, deviation);
  image.convertTo(sum, CV_16SC3);
  sum += noise;
  sum.convertTo(sum, CV_8UC3);
  return sum;
}

cv::Mat StandingStill(const cv::Mat& last, int step) { return WithNoise(last, 2.0, 100 + step); }

cv::Mat StandingAmongMovers(const cv::Mat& last, int step) {
  cv::Mat crossed = last.clone();
  for (int box = 0; box < 3; ++box) {
    const cv::Size size(44 - 8 * box, 26);
    cv::Mat coarse(7, 11, CV_8UC3), texture;
    cv::RNG(box + 1).fill(coarse, cv::RNG::UNIFORM, 30 * box, 120 + 60 * box);
    cv::resize(coarse, texture, size, 0.0, 0.0, cv::INTER_CUBIC);
    const int speed = box == 1 ? -2 : 2 + box;
    const int range = last.cols - size.width;
    const int x = ((speed * step + 70 * box) % range + range) % range;
    texture.copyTo(crossed(cv::Rect(cv::Point(x, 45 + 30 * box), size)));
  }
  return WithNoise(crossed, 2.0, 500 + step);
}

double AucOfTheEnd(DriveProfile profile, const Disturbance& disturbance) {
  return Auc(profile, &disturbance, cv::Size());
}

double UndisturbedAuc(DriveProfile profile, cv::Size size) { return Auc(profile, nullptr, size); }

}  // namespace egosieve::vision
