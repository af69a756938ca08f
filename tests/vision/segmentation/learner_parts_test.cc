#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <random>
#include <vector>

#include "gp/covariance/hyperparameters.h"
#include "kernels/base/exception_status.h"
#include "kernels/runtime/context.h"
#include "tests/testing/status.h"
#include "tests/vision/segmentation/moving_square.h"
#include "vision/segmentation/frame_calibration.h"
#include "vision/segmentation/label_residual.h"
#include "vision/segmentation/learner_model.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/segmentation/rows.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::vision {
namespace {

constexpr int kWidth = 101, kHeight = 61;

double Logit(double p) { return std::log(p / (1.0 - p)); }

// Two places, on the left and on the right.
LabelResidual TwoPlaces(int64_t frame, const std::vector<double>& labels,
                        const std::vector<float>& own) {
  const std::vector<double> positions = {10.0, 30.0, 90.0, 30.0};
  return LabelResidual(frame, cv::Size(kWidth, kHeight), {positions.data(), 2, 2}, labels, own);
}

SegmentationMap FlatMap(int64_t frame, int stride, float probability) {
  SegmentationMap map{.frame_index = frame, .grid = {kWidth, kHeight, stride}};
  map.probability.assign(map.grid.size(), probability);
  return map;
}

float At(const SegmentationMap& map, int column, int row) {
  return map.probability[row * map.grid.columns() + column];
}

// (LR1), (LR2); residuals are kept in steps of 1/12, of which half is the error in the log odds.
TEST(LabelResidual, RaisesTheLogOddsByAPartOfWhatTheProcessLeaves) {
  const LabelResidual residual = TwoPlaces(7, {0.9, 0.2}, {0.3f, 0.4f});
  for (const int stride : {1, 5, 7}) {
    SegmentationMap map = FlatMap(7, stride, 0.3f);
    residual.Apply(0.5, map);
    const int last = map.grid.columns() - 1, bottom = map.grid.rows() - 1;
    const double bound = 0.5 * 0.5 / 12.0 + 1e-5;
    for (const int row : {0, bottom}) {
      EXPECT_NEAR(Logit(At(map, 0, row)), Logit(0.3) + 0.5 * (Logit(0.9) - Logit(0.3)), bound);
      EXPECT_NEAR(Logit(At(map, last, row)), Logit(0.3) + 0.5 * (Logit(0.2) - Logit(0.4)), bound);
    }
  }
}

TEST(LabelResidual, ALabelThatItsNeighboursDoNotShareChangesNothing) {
  std::vector<double> positions, labels;
  std::vector<float> own;
  for (int y = 0; y < kHeight; y += 5) {
    for (int x = 0; x < kWidth; x += 5) {
      const bool is_single = x == 20 && y == 30, is_mover = x >= 60 && x < 75 && y >= 20 && y < 40;
      positions.insert(positions.end(), {static_cast<double>(x), static_cast<double>(y)});
      labels.push_back(is_single || is_mover ? 0.95 : 0.1);
      own.push_back(0.1f);
    }
  }
  const LabelResidual residual(7, cv::Size(kWidth, kHeight),
                               {positions.data(), static_cast<int64_t>(labels.size()), 2}, labels,
                               own);
  SegmentationMap map = FlatMap(7, 5, 0.1f);
  residual.Apply(1.0, map);
  EXPECT_NEAR(At(map, 20 / 5, 30 / 5), 0.1f, 1e-3f);
  EXPECT_GT(At(map, 65 / 5, 30 / 5), 0.9f);
}

TEST(LabelResidual, TheWholeWeightGivesTheLabelAndNoneTheProcess) {
  const LabelResidual residual = TwoPlaces(7, {0.95, 0.05}, {0.1f, 0.6f});
  SegmentationMap all = FlatMap(7, 5, 0.1f), none = FlatMap(7, 5, 0.1f);
  residual.Apply(1.0, all);
  residual.Apply(0.0, none);
  EXPECT_NEAR(Logit(At(all, 0, 0)), Logit(0.95), 0.5 / 12.0 + 1e-5);
  EXPECT_NEAR(At(none, 0, 0), 0.1f, 1e-6f);
}

// A label of 1 where the process says 0 is the largest there is: 2 logit(0.99), in a byte.
TEST(LabelResidual, CertainLabelsStayFinite) {
  const LabelResidual residual = TwoPlaces(7, {1.0, 0.0}, {0.0f, 1.0f});
  SegmentationMap map = FlatMap(7, 5, 0.0f);
  residual.Apply(1.0, map);
  EXPECT_NEAR(Logit(At(map, 0, 0)), Logit(1e-6) + 2.0 * Logit(0.99), 0.06);
  EXPECT_LT(At(map, map.grid.columns() - 1, 0), 1e-6f);
}

TEST(LabelResidual, ChangesNoMapButItsOwn) {
  const LabelResidual residual = TwoPlaces(7, {0.9, 0.9}, {0.1f, 0.1f});
  SegmentationMap other_frame = FlatMap(8, 5, 0.3f), other_size = FlatMap(7, 5, 0.3f);
  other_size.grid.width = kWidth - 1;
  for (SegmentationMap* map : {&other_frame, &other_size}) {
    const std::vector<float> before = map->probability;
    residual.Apply(1.0, *map);
    EXPECT_EQ(map->probability, before);
  }
  SegmentationMap map = FlatMap(7, 5, 0.3f);
  const std::vector<float> before = map.probability;
  LabelResidual().Apply(1.0, map);
  LabelResidual(7, cv::Size(kWidth, kHeight), {nullptr, 0, 2}, {}, {}).Apply(1.0, map);
  EXPECT_EQ(map.probability, before);
}

// Places of a line from -1 to 1; what lies right of 0.8 moves: a tenth. The model holds every 20th.
class FrameCalibration : public testing::Test {
 protected:
  static constexpr int kPlaces = 1000;

  void SetUp() override {
    std::vector<int64_t> held;
    for (int i = 0; i < kPlaces; ++i) {
      const float x = 2.0f * (static_cast<float>(i) + 0.5f) / kPlaces - 1.0f;
      inputs_.insert(inputs_.end(), {x, 0.1f});
      labels_.push_back(x > 0.8f ? 0.95 : 0.01);
      if (i % 20 == 10) held.push_back(i);
    }
    left_ = Complement(kPlaces, held);
    const auto context = Value(kernels::OpenContext());
    const auto theta =
        gp::DefaultHyperparameters(kernels::CovarianceFunction::kSquaredExponential, 2);
    auto model = LearnerModel::Create(context, theta, {});
    ASSERT_TRUE(model.ok()) << model.status();
    const std::vector<float> points = GatherRows(Inputs(), held);
    ASSERT_TRUE(model
                    ->Add(kernels::ConstMatrixView<float>(points.data(),
                                                          static_cast<int64_t>(held.size()), 2),
                          Gather(labels_, held), 0)
                    .ok());
    posterior_ = Value(model->MakePosterior({}));
  }

  kernels::ConstMatrixView<float> Inputs() const {
    return kernels::ConstMatrixView<float>(inputs_.data(), kPlaces, 2);
  }

  std::vector<float> inputs_;
  std::vector<double> labels_;
  std::vector<int64_t> left_;
  std::shared_ptr<const gp::Posterior> posterior_;
};

TEST_F(FrameCalibration, ProbabilitiesFollowTheFramesOwnPlacesAndShare) {
  const auto squash = Value(FitSquashToFrame(*posterior_, Inputs(), labels_, left_, 400, 1));
  std::vector<float> mean(kPlaces), variance(kPlaces);
  const kernels::PosteriorOutputs outputs{.mean = mean.data(), .variance = variance.data()};
  ASSERT_TRUE(posterior_->Evaluate(Inputs(), outputs).ok());
  double sum = 0.0, labels = 0.0, before = 0.0;
  for (int i = 0; i < kPlaces; ++i) {
    sum += squash.Probability(mean[i], variance[i]);
    before += gp::SquashParameters().Probability(mean[i], variance[i]);
    labels += labels_[i];
  }
  // A probit with a free offset matches means nearly, not exactly.
  EXPECT_NEAR(sum / kPlaces, labels / kPlaces, 0.02);
  EXPECT_GT(std::abs(before - labels) / kPlaces, 0.04);
  EXPECT_GT(squash.Probability(mean[970], variance[970]), 0.7);
  EXPECT_LT(squash.Probability(mean[500], variance[500]), 0.05);
}

TEST(SpreadToGrid, EveryPixelTakesItsNearestFeature) {
  const ImageGrid grid{83, 41, 5};
  std::mt19937_64 random(1);
  std::vector<double> positions, values;
  for (int i = 0; i < 60; ++i) {
    positions.push_back(static_cast<double>(random() % 8200) / 100.0);
    positions.push_back(static_cast<double>(random() % 4000) / 100.0);
    values.push_back(i);
  }
  const std::vector<float> spread = SpreadToGrid({positions.data(), 60, 2}, values, grid);
  ASSERT_EQ(static_cast<int64_t>(spread.size()), grid.size());
  size_t next = 0;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      size_t best = 0;
      double least = 1e9;
      for (size_t i = 0; i < values.size(); ++i) {
        const double distance = std::hypot(positions[2 * i] - grid.x_pixels(column),
                                           positions[2 * i + 1] - grid.y_pixels(row));
        if (distance < least) {
          least = distance;
          best = i;
        }
      }
      EXPECT_EQ(spread[next++], static_cast<float>(best));
    }
  }
}

TEST(SpreadToGrid, TiesGoToTheFirstAndNothingIsZero) {
  const ImageGrid grid{11, 1, 10};
  const std::vector<double> positions = {5.0, 0.0, 5.0, 0.0};
  EXPECT_EQ(SpreadToGrid({positions.data(), 2, 2}, {3.0, 4.0}, grid),
            (std::vector<float>{3.0f, 3.0f}));
  EXPECT_EQ(SpreadToGrid({nullptr, 0, 2}, {}, grid), (std::vector<float>{0.0f, 0.0f}));
}

TEST(ExpectedOverlap, IsThatOfDrawnTruths) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> uniform;
  std::vector<float> probability(20000);
  for (float& p : probability) p = uniform(random) * uniform(random);
  double overlap = 0.0;
  constexpr int kTruths = 20;
  for (int t = 0; t < kTruths; ++t) {
    double both = 0.0, either = 0.0;
    for (const float p : probability) {
      const bool moves = uniform(random)<p, marked = p> 0.5f;
      both += moves && marked;
      either += moves || marked;
    }
    overlap += both / either / kTruths;
  }
  EXPECT_NEAR(ExpectedOverlap(probability), overlap, 0.005);
}

TEST(ExpectedOverlap, OfMapsWithoutAMaskIsTheChanceThatNothingMoves) {
  // Half a mover of 3 % of the picture is expected, however the probability is spread.
  std::vector<float> probability(200, 0.015f);
  EXPECT_NEAR(ExpectedOverlap(probability), std::exp(-0.5), 1e-6);
  probability.assign(200, 0.0f);
  for (int i = 0; i < 10; ++i) probability[i] = 0.3f;
  EXPECT_NEAR(ExpectedOverlap(probability), std::exp(-0.5), 1e-6);
  EXPECT_EQ(ExpectedOverlap({0.0f, 0.0f}), 1.0);
  EXPECT_TRUE(std::isnan(ExpectedOverlap({})));
}

}  // namespace
}  // namespace egosieve::vision
