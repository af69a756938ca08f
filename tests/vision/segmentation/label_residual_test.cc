#include "vision/segmentation/label_residual.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"

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
  SegmentationMap map;
  map.frame_index = frame;
  map.grid = {kWidth, kHeight, stride};
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

}  // namespace
}  // namespace egosieve::vision
