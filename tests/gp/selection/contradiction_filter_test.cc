#include "gp/selection/contradiction_filter.h"

#include <cmath>
#include <limits>
#include <vector>

#include "gtest/gtest.h"
#include "tests/gp/learning_problems.h"

namespace egosieve::gp {
namespace {

using FloatMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

kernels::ConstMatrixView<float> NarrowView(const FloatMatrix& x) {
  return {x.data(), x.rows(), x.cols()};
}

// The definition, by brute force.
std::vector<int64_t> Definition(const RowMatrix& x, const std::vector<double>& labels,
                                const FloatMatrix& newer, const std::vector<double>& newer_labels,
                                double radius) {
  std::vector<int64_t> kept;
  for (int64_t i = 0; i < x.rows(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    double label = labels[i];
    for (int64_t j = 0; j < newer.rows(); ++j) {
      const double distance = (x.row(i) - newer.row(j).cast<double>()).norm();
      if (distance < nearest) {
        nearest = distance;
        label = newer_labels[j];
      }
    }
    if (!(nearest < radius && (label >= 0.5) != (labels[i] >= 0.5))) kept.push_back(i);
  }
  return kept;
}

TEST(ContradictionFilter, FollowsItsDefinition) {
  auto generator = TestGenerator();
  const LabelledPoints old = NoisyBlobs(300, 3, generator), newer = NoisyBlobs(500, 3, generator);
  const FloatMatrix narrow = newer.inputs.cast<float>();
  size_t last = 301;
  for (const double radius : {0.0, 0.05, 0.15}) {
    const auto kept = FilterByContradiction(ViewOf(old.inputs), old.labels, NarrowView(narrow),
                                            newer.labels, radius);
    ASSERT_TRUE(kept.ok()) << kept.status();
    EXPECT_EQ(*kept, Definition(old.inputs, old.labels, narrow, newer.labels, radius));
    EXPECT_LT(kept->size(), last) << radius;
    last = kept->size();
  }
}

// A mover that was at 0 is at 1 now.
TEST(ContradictionFilter, ForgetsWhereAMoverWas) {
  const RowMatrix old = (RowMatrix(4, 1) << 0.0, 1.0, 0.02, 3.0).finished();
  const std::vector<double> old_labels = {0.9, 0.1, 0.2, 0.9};
  const FloatMatrix now = (FloatMatrix(2, 1) << 0.01f, 1.01f).finished();
  const std::vector<double> now_labels = {0.1, 0.9};
  const auto kept =
      FilterByContradiction(ViewOf(old), old_labels, NarrowView(now), now_labels, 0.1);
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(*kept, (std::vector<int64_t>{2, 3}));
}

TEST(ContradictionFilter, NothingToCompare) {
  const RowMatrix old = RowMatrix::Zero(2, 3);
  const auto kept = FilterByContradiction(ViewOf(old), {0.0, 1.0},
                                          kernels::ConstMatrixView<float>(nullptr, 0, 3), {}, 1.0);
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(*kept, (std::vector<int64_t>{0, 1}));
}

TEST(ContradictionFilter, RefusesWhatIsNoInput) {
  RowMatrix old = RowMatrix::Zero(1, 2);
  const FloatMatrix now = FloatMatrix::Zero(1, 2), other = FloatMatrix::Zero(1, 3);
  const auto filter = [&](const FloatMatrix& newer, double label, double radius) {
    return FilterByContradiction(ViewOf(old), {0.5}, NarrowView(newer), {label}, radius).status();
  };
  EXPECT_TRUE(filter(now, 0.5, 0.1).ok());
  EXPECT_TRUE(absl::IsInvalidArgument(filter(other, 0.5, 0.1)));
  EXPECT_TRUE(absl::IsInvalidArgument(filter(now, 1.5, 0.1)));
  EXPECT_TRUE(absl::IsInvalidArgument(filter(now, 0.5, -0.1)));
  EXPECT_TRUE(absl::IsInvalidArgument(filter(now, 0.5, std::nan(""))));
  old(0, 1) = std::nan("");
  EXPECT_TRUE(absl::IsInvalidArgument(filter(now, 0.5, 0.1)));
}

}  // namespace
}  // namespace egosieve::gp
