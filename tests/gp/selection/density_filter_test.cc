#include "gp/selection/density_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "gtest/gtest.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

// The definition, by brute force.
std::vector<int64_t> Definition(const RowMatrix& x, const std::vector<double>& labels,
                                double radius, const std::vector<int64_t>& order) {
  std::vector<int64_t> kept;
  for (const int64_t i : order) {
    const bool near = std::any_of(kept.begin(), kept.end(), [&](int64_t j) {
      return (labels[i] >= 0.5) == (labels[j] >= 0.5) &&
             (x.row(i) - x.row(j)).squaredNorm() < radius * radius;
    });
    if (!near) kept.push_back(i);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

TEST(DensityFilter, FollowsItsDefinition) {
  auto generator = TestGenerator();
  for (const int64_t n : {0, 1, 2, 50, 700}) {
    for (const double radius : {0.0, 0.08, 0.3, 10.0}) {
      const LabelledPoints points = NoisyBlobs(n, 3, generator);
      std::vector<int64_t> order(n);
      std::iota(order.begin(), order.end(), int64_t{0});
      const auto kept = Value(FilterByDensity(ViewOf(points.inputs), points.labels, {radius}));
      EXPECT_EQ(kept, Definition(points.inputs, points.labels, radius, order));
      std::reverse(order.begin(), order.end());
      const auto newest =
          Value(FilterByDensity(ViewOf(points.inputs), points.labels, {radius}, order));
      EXPECT_EQ(newest, Definition(points.inputs, points.labels, radius, order));
    }
  }
}

TEST(DensityFilter, SingleAndDoublePrecisionAgree) {
  auto generator = TestGenerator();
  LabelledPoints points = NoisyBlobs(500, 6, generator);
  const NarrowMatrix narrow = points.inputs.cast<float>();
  points.inputs = narrow.cast<double>();
  const auto wide = Value(FilterByDensity(ViewOf(points.inputs), points.labels, {0.6}));
  const auto slim = Value(FilterByDensity(kernels::ConstMatrixView<float>(narrow.data(), 500, 6),
                                          points.labels, {0.6}));
  EXPECT_EQ(wide, slim);
  EXPECT_LT(wide.size(), 480u);
}

TEST(DensityFilter, DuplicatesOfEachSideLeaveOneEach) {
  const RowMatrix x = RowMatrix::Constant(1000, 6, 0.25);
  std::vector<double> labels(1000, 0.0);
  labels[600] = 0.5;  // counts as high
  const auto kept = Value(FilterByDensity(ViewOf(x), labels, {1e-9}));
  EXPECT_EQ(kept, (std::vector<int64_t>{0, 600}));
}

TEST(DensityFilter, RefusesBadArguments) {
  RowMatrix x = RowMatrix::Zero(3, 2);
  const auto code = [&](std::vector<double> labels, double radius,
                        std::vector<int64_t> order = {}) {
    return FilterByDensity(ViewOf(x), labels, {radius}, order).status().code();
  };
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_EQ(code({0.0, 1.0}, 0.1), kInvalid);
  EXPECT_EQ(code({0.0, 1.0, 2.0}, 0.1), kInvalid);
  EXPECT_EQ(code({0.0, 1.0, 1.0}, -0.1), kInvalid);
  EXPECT_EQ(code({0.0, 1.0, 1.0}, std::nan("")), kInvalid);
  EXPECT_EQ(code({0.0, 1.0, 1.0}, 0.1, {0, 1}), kInvalid);
  EXPECT_EQ(code({0.0, 1.0, 1.0}, 0.1, {0, 1, 1}), kInvalid);
  EXPECT_EQ(code({0.0, 1.0, 1.0}, 0.1, {0, 1, 3}), kInvalid);
  x(2, 1) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(code({0.0, 1.0, 1.0}, 0.1), kInvalid);
}

}  // namespace
}  // namespace egosieve::gp
