// What goes wrong with a camera in a long drive: every frame is answered, the log says why nothing
// was learnt, and once the pictures are good again so are the maps.
//
// A synthetic drive is played to its middle, then comes the disturbance, then its second half. The
// maps of the last frames, that have had time to recover, are scored against the drive's masks and
// against the same frames of a drive without the disturbance.
#include <cmath>
#include <functional>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/runtime/context.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/synthetic/street.h"

namespace egosieve::vision {
namespace {

constexpr int kFrames = 28;
constexpr int kMiddle = 14;  // the disturbance comes before this frame
constexpr int kScoredFrom = 20;
constexpr double kAllowedLoss = 0.02;

struct Drive {
  std::vector<cv::Mat> images, masks;
};

const Drive& TheDrive() {
  static const Drive& drive = *[] {
    ScenarioOptions options;
    options.width_pixels = 320;
    options.height_pixels = 180;
    options.frames = 60;
    const auto scenario = MakeScenario("junction", 1, options);
    auto* drive = new Drive;
    for (int i = 0; i < kFrames; ++i) {
      SyntheticFrame frame = *scenario->Render(20 + i);
      drive->images.push_back(frame.image);
      drive->masks.push_back(frame.mask);
    }
    return drive;
  }();
  return drive;
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

cv::Mat Uniform(int value, double noise, uint64_t seed) {
  return WithNoise(cv::Mat(TheDrive().images[0].size(), CV_8UC3, cv::Scalar::all(value)), noise,
                   seed);
}

// The picture of a camera of 75 degrees that has turned about its vertical axis.
cv::Mat Turned(const cv::Mat& image, double degrees) {
  const double focal = 0.5 * image.cols / std::tan(37.5 * M_PI / 180.0);
  const double angle = degrees * M_PI / 180.0;
  const cv::Matx33d k(focal, 0, 0.5 * image.cols, 0, focal, 0.5 * image.rows, 0, 0, 1);
  const cv::Matx33d r(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0,
                      std::cos(angle));
  cv::Mat turned;
  cv::warpPerspective(image, turned, k * r * k.inv(), image.size(), cv::INTER_LINEAR,
                      cv::BORDER_REFLECT);
  return turned;
}

// A blurred hand of skin's colour that covers most of the picture and trembles.
cv::Mat WithHand(const cv::Mat& image, int step) {
  cv::Mat covered = image.clone();
  const cv::Point shake((step * 7) % 11 - 5, (step * 5) % 9 - 4);
  cv::ellipse(covered, cv::Point(image.cols / 2, image.rows / 2) + shake,
              cv::Size(image.cols * 6 / 10, image.rows * 6 / 10), 20.0, 0.0, 360.0,
              cv::Scalar(110, 140, 200), cv::FILLED);
  cv::GaussianBlur(covered, covered, cv::Size(), 5.0);
  return WithNoise(covered, 2.0, step);
}

// A dark bar across the picture that moves from one side to the other.
cv::Mat WithWiper(const cv::Mat& image, int step) {
  cv::Mat wiped = image.clone();
  const int x = image.cols * (step + 1) / 8;
  cv::line(wiped, {x, 0}, {x - image.cols / 6, image.rows}, cv::Scalar::all(15), image.cols / 12);
  return wiped;
}

struct Disturbance {
  std::string name;
  std::vector<cv::Mat> (*frames)(const cv::Mat& last);  // after frame kMiddle - 1, the last
  int skipped;                                          // of the drive's own frames
  bool nothing_is_learnt;                               // from the disturbing frames
};

template <typename Make>
std::vector<cv::Mat> Repeat(int count, const Make& make) {
  std::vector<cv::Mat> frames;
  for (int i = 0; i < count; ++i) frames.push_back(make(i));
  return frames;
}

const std::vector<Disturbance>& Disturbances() {
  static const auto& disturbances = *new std::vector<Disturbance>{
      {"FramesMissing", [](const cv::Mat&) { return std::vector<cv::Mat>(); }, 2, false},
      {"Black", [](const cv::Mat&) { return Repeat(6, [](int i) { return Uniform(2, 1.0, i); }); },
       0, true},
      {"OverExposed",
       [](const cv::Mat&) { return Repeat(6, [](int i) { return Uniform(255, 1.0, i); }); }, 0,
       true},
      {"AllGrey",
       [](const cv::Mat&) { return Repeat(6, [](int i) { return Uniform(128, 3.0, i); }); }, 0,
       true},
      {"Duplicated",
       [](const cv::Mat& last) { return Repeat(6, [&](int) { return last.clone(); }); }, 0, true},
      {"SizeChanged",
       [](const cv::Mat& last) {
         return Repeat(3, [&](int i) {
           cv::Mat other;
           cv::resize(last, other, cv::Size(200 + 40 * i, 120));
           return other;
         });
       },
       0, true},
      {"StandingStill",
       [](const cv::Mat& last) {
         return Repeat(40, [&](int i) { return WithNoise(last, 2.0, 100 + i); });
       },
       0, false},
      {"PureRotation",
       [](const cv::Mat& last) {
         return Repeat(10, [&](int i) {
           return WithNoise(Turned(last, 1.5 * (5 - std::abs(i - 5))), 2.0, 200 + i);
         });
       },
       0, false},
      {"HandOverTheLens",
       [](const cv::Mat& last) { return Repeat(6, [&](int i) { return WithHand(last, i); }); }, 0,
       false},
      {"Wiper",
       [](const cv::Mat& last) { return Repeat(6, [&](int i) { return WithWiper(last, i); }); }, 0,
       false},
  };
  return disturbances;
}

void PrintTo(const Disturbance& disturbance, std::ostream* out) { *out << disturbance.name; }

struct Case {
  Disturbance disturbance;
  bool fast = false;
};

void PrintTo(const Case& test, std::ostream* out) { PrintTo(test.disturbance, out); }

std::vector<Case> Cases() {
  std::vector<Case> cases;
  for (const Disturbance& disturbance : Disturbances()) cases.push_back({disturbance, false});
  for (const Disturbance& disturbance : Disturbances()) {
    if (!disturbance.nothing_is_learnt) cases.push_back({disturbance, true});
  }
  return cases;
}

class DisturbanceTest : public testing::TestWithParam<Case> {
 protected:
  static std::unique_ptr<OnlineSegmenter> MakeSegmenter(bool fast) {
    OnlineSegmenterOptions options =
        fast ? OnlineSegmenterOptions::Fast() : OnlineSegmenterOptions::Default();
    options.learner.budget.budget = 600;
    options.learner.training.annealing_evaluations = 40;
    options.learner.training.subset_size = 300;
    auto context = kernels::OpenContext();
    EXPECT_TRUE(context.ok()) << context.status();
    return *OnlineSegmenter::Create(*context, options);
  }

  OnlineSegmenter::Result Process(OnlineSegmenter& segmenter, const cv::Mat& image) {
    Frame frame;
    frame.index = next_index_;
    frame.time_seconds = 0.1 * static_cast<double>(next_index_++);
    frame.image = image;
    auto result = segmenter.Process(frame);
    EXPECT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->map.grid.width, image.cols);
    EXPECT_EQ(static_cast<int64_t>(result->map.probability.size()), result->map.grid.size());
    EXPECT_NE(result->record.learnt, !result->record.reason.empty());
    for (const float p : result->map.probability) EXPECT_TRUE(p >= 0.0f && p <= 1.0f);
    return *std::move(result);
  }

  // Of all pixels of the frames scored: Mann-Whitney by counting 1,024 levels.
  struct Scores {
    std::vector<double> positive = std::vector<double>(1025), negative = positive;
    double Auc() const {
      double below = 0.0, ordered = 0.0, p = 0.0, n = 0.0;
      for (size_t v = 0; v < positive.size(); ++v) {
        ordered += positive[v] * (below + 0.5 * negative[v]);
        below += negative[v];
        p += positive[v];
        n += negative[v];
      }
      return ordered / (p * n);
    }
  };

  void Score(const SegmentationMap& map, const cv::Mat& mask, Scores& scores) const {
    for (int row = 0; row < map.grid.rows(); ++row) {
      for (int column = 0; column < map.grid.columns(); ++column) {
        const bool moves = mask.at<uint8_t>(map.grid.y_pixels(row), map.grid.x_pixels(column)) != 0;
        const float p = map.probability[row * map.grid.columns() + column];
        (moves ? scores.positive : scores.negative)[std::lround(1024.0f * p)] += 1.0;
      }
    }
  }

  // The drive with `disturbance` in its middle, or without.
  double AucOfTheEnd(bool fast, const Disturbance* disturbance) {
    auto segmenter = MakeSegmenter(fast);
    next_index_ = 0;
    Scores scores;
    for (int i = 0; i < kFrames; ++i) {
      if (disturbance != nullptr && i == kMiddle) {
        for (const cv::Mat& image : disturbance->frames(TheDrive().images[i - 1])) {
          const OnlineSegmenter::Result result = Process(*segmenter, image);
          if (disturbance->nothing_is_learnt) {
            EXPECT_FALSE(result.record.learnt) << result.record.frame_index;
          }
        }
        i += disturbance->skipped;
      }
      const OnlineSegmenter::Result result = Process(*segmenter, TheDrive().images[i]);
      if (i >= kScoredFrom) {
        EXPECT_TRUE(result.record.learnt) << result.record.reason;
        Score(result.map, TheDrive().masks[i], scores);
      }
    }
    return scores.Auc();
  }

  double UndisturbedAuc(bool fast) {
    static double auc[2] = {-1.0, -1.0};
    if (auc[fast] < 0.0) auc[fast] = AucOfTheEnd(fast, nullptr);
    return auc[fast];
  }

  int64_t next_index_ = 0;
};

TEST_P(DisturbanceTest, LeavesTheModelSound) {
  const double undisturbed = UndisturbedAuc(GetParam().fast);
  EXPECT_GT(undisturbed, 0.8);
  const double disturbed = AucOfTheEnd(GetParam().fast, &GetParam().disturbance);
  RecordProperty("auc", std::to_string(disturbed));
  EXPECT_GE(disturbed, undisturbed - kAllowedLoss);
}

INSTANTIATE_TEST_SUITE_P(Drives, DisturbanceTest, testing::ValuesIn(Cases()), [](const auto& test) {
  return test.param.disturbance.name + (test.param.fast ? "Fast" : "Default");
});

}  // namespace
}  // namespace egosieve::vision
