#include "vision/segmentation/learner_model.h"

#include <random>

#include "kernels/runtime/context.h"
#include "tests/testing/status.h"

namespace egosieve::vision {
namespace {

constexpr int64_t kDimension = 2;

struct Points {
  std::vector<float> inputs;
  std::vector<double> labels;
  kernels::ConstMatrixView<float> view() const {
    return {inputs.data(), static_cast<int64_t>(labels.size()), kDimension};
  }
};

// Points of the square [-1, 1]^2, dynamic where x > 0.
Points MakePoints(int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  Points points;
  for (int i = 0; i < count; ++i) {
    for (int d = 0; d < kDimension; ++d) {
      points.inputs.push_back(static_cast<float>(random() % 20001) / 10000.0f - 1.0f);
    }
    points.labels.push_back(points.inputs[i * kDimension] > 0.0f ? 0.9 : 0.1);
  }
  return points;
}

class LearnerModelTest : public testing::TestWithParam<ModelKind> {
 protected:
  LearnerModel MakeModel() const {
    LearnerModelOptions options;
    options.kind = GetParam();
    options.sparse.inducing_points = 40;
    auto context = Value(kernels::OpenContext());
    return Value(LearnerModel::Create(
        context, gp::DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, kDimension),
        options));
  }

  static std::vector<float> Map(const LearnerModel& model) {
    const Points queries = MakePoints(50, 99);
    std::vector<float> probability(queries.labels.size());
    kernels::PosteriorOutputs outputs;
    outputs.probability = probability.data();
    const auto posterior = Value(model.MakePosterior({}));
    EXPECT_TRUE(posterior->Evaluate(queries.view(), outputs).ok());
    return probability;
  }

  static std::vector<int64_t> Rows(int64_t begin, int64_t end) {
    std::vector<int64_t> rows;
    for (int64_t row = begin; row < end; ++row) rows.push_back(row);
    return rows;
  }
};

INSTANTIATE_TEST_SUITE_P(Models, LearnerModelTest,
                         testing::Values(ModelKind::kExact, ModelKind::kSparse),
                         [](const auto& kind) {
                           return kind.param == ModelKind::kExact ? "Exact" : "Sparse";
                         });

// What removals leave of a sum must not break the posterior, however little is left.
TEST_P(LearnerModelTest, HasAPosteriorAfterEveryRemoval) {
  LearnerModel model = MakeModel();
  gp::Hyperparameters theta = model.hyperparameters();
  theta.noise_stddev = 0.001;  // large terms, and so large rounding
  ASSERT_TRUE(model.SetHyperparameters(theta).ok());
  const Points points = MakePoints(200, 3);
  ASSERT_TRUE(model.Add(points.view(), points.labels, 0).ok());
  for (int64_t size = 200; size > 0; size -= 1) {
    ASSERT_EQ(model.size(), size);
    for (const float probability : Map(model)) {
      ASSERT_TRUE(probability >= 0.0f && probability <= 1.0f);
    }
    ASSERT_TRUE(model.Remove(Rows(0, 1)).ok());
  }
  for (const float probability : Map(model)) ASSERT_FLOAT_EQ(probability, 0.5f);
}

TEST_P(LearnerModelTest, RestoredFromItsStateItIsAsAfterRebuild) {
  LearnerModel model = MakeModel();
  const Points first = MakePoints(100, 1), second = MakePoints(10, 2);
  ASSERT_TRUE(model.Add(first.view(), first.labels, 0).ok());
  ASSERT_TRUE(model.Remove(Rows(0, 5)).ok());
  ASSERT_TRUE(model.Rebuild().ok());
  LearnerModel restored = MakeModel();
  ASSERT_TRUE(restored.Restore(model.State()).ok());
  for (LearnerModel* each : {&model, &restored}) {
    ASSERT_TRUE(each->Add(second.view(), second.labels, 1).ok());
  }
  EXPECT_EQ(Map(restored), Map(model));
}

// Whether it was asked in between or not.
TEST(SparseLearnerModelTest, DependsOnItsPointsAndNotOnItsHistory) {
  LearnerModelOptions options;
  options.kind = ModelKind::kSparse;
  options.sparse.inducing_points = 40;
  auto context = Value(kernels::OpenContext());
  const auto make = [&] {
    return Value(LearnerModel::Create(
        context, gp::DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, kDimension),
        options));
  };
  const Points first = MakePoints(120, 1), second = MakePoints(5, 2);
  LearnerModel model = make();
  ASSERT_TRUE(model.Add(first.view(), first.labels, 0).ok());
  const double before = model.LogMarginalLikelihood();
  ASSERT_TRUE(model.Remove({3, 17}).ok());
  EXPECT_NE(model.LogMarginalLikelihood(), before);
  ASSERT_TRUE(model.Add(second.view(), second.labels, 1).ok());
  LearnerModel fresh = make();
  ASSERT_TRUE(fresh.Restore(model.State()).ok());
  EXPECT_EQ(fresh.LogMarginalLikelihood(), model.LogMarginalLikelihood());
  EXPECT_EQ(*fresh.PredictOwnMean(), *model.PredictOwnMean());
}

TEST(LearnerModelOptionsTest, TheSubsetOfRegressorsIsRefused) {
  LearnerModelOptions options;
  EXPECT_TRUE(options.Validate().ok());
  options.sparse.approximation = gp::SparseApproximation::kSubsetOfRegressors;
  EXPECT_THAT(options.Validate(), IsInvalid());
}

}  // namespace
}  // namespace egosieve::vision
