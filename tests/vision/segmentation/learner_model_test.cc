#include "vision/segmentation/learner_model.h"

#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "kernels/runtime/context.h"
#include "tests/testing/status.h"
#include "vision/segmentation/online_learner.h"
#include "vision/segmentation/online_segmenter.h"

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
    LearnerModelOptions options{.kind = GetParam()};
    options.sparse.inducing_points = 40;
    auto context = Value(kernels::OpenContext());
    return Value(LearnerModel::Create(
        context, gp::DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, kDimension),
        options));
  }

  static std::vector<float> Map(const LearnerModel& model) {
    const Points queries = MakePoints(50, 99);
    std::vector<float> probability(queries.labels.size());
    const kernels::PosteriorOutputs outputs{.probability = probability.data()};
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
  LearnerModelOptions options{.kind = ModelKind::kSparse};
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

constexpr int64_t kInputs = 6;
constexpr int kStatic = 600, kMover = 16;

// What the paper's labels look like on a street: most are small, one in thirty is large by a false
// match, and of a small mover's a good half are.
struct Street {
  std::vector<float> inputs;
  std::vector<double> labels;

  explicit Street(uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    for (int i = 0; i < kStatic + kMover; ++i) {
      const bool mover = i >= kStatic;
      inputs.push_back(static_cast<float>(mover ? uniform(0.25, 0.45) : uniform(-1.0, 1.0)));
      inputs.push_back(static_cast<float>(mover ? uniform(0.0, 0.15) : uniform(-0.6, 0.6)));
      const double grey = mover ? uniform(0.5, 0.8) : uniform(-0.6, 0.2);
      for (int channel = 0; channel < 4; ++channel) inputs.push_back(static_cast<float>(grey));
      const bool large = uniform(0.0, 1.0) < (mover ? 0.6 : 0.03);
      labels.push_back(large ? uniform(0.5, 1.0) : uniform(0.0, 0.3));
    }
  }

  int64_t size() const { return static_cast<int64_t>(labels.size()); }
};

std::unique_ptr<OnlineLearner> MakeLearner(const OnlineLearnerOptions& options) {
  return Value(OnlineLearner::Create(*kernels::OpenContext(), kInputs, options));
}

void LearnStreet(int frame, OnlineLearner& learner) {
  const Street street(static_cast<uint64_t>(frame));
  FrameRecord record;
  EXPECT_EQ(
      learner.Learn(kernels::ConstMatrixView<float>(street.inputs.data(), street.size(), kInputs),
                    street.labels, frame, record),
      absl::OkStatus());
}

std::vector<double> Targets(const OnlineLearner& learner) {
  return {learner.model().targets().begin(), learner.model().targets().end()};
}

// Points of the model with dynamic labels after some frames.
int64_t DynamicPoints(const OnlineLearnerOptions& options, int frames) {
  const auto learner = MakeLearner(options);
  for (int frame = 1; frame <= frames; ++frame) LearnStreet(frame, *learner);
  int64_t dynamic = 0;
  for (const double target : learner->model().targets()) {
    const double label = learner->zero_label() + (1.0 - learner->zero_label()) * target;
    dynamic += label >= 0.5 - 1e-9;
  }
  return dynamic;
}

// With the prior mean at undecided, the paper's filter 3 empties the rarer class for good.
TEST(OnlineLearner, WithDataScaledToMeanZeroTheRareClassStays) {
  OnlineLearnerOptions paper = OnlineSegmenterOptions::Paper().learner;
  EXPECT_GE(DynamicPoints(paper, 6), kMover / 4);
  paper.scales_to_mean_zero = false;
  paper.zero_label = 0.5;
  EXPECT_EQ(DynamicPoints(paper, 6), 0);
}

// (T1) with the model's own mean label. A target is a rounding of 1 off: n of them sum to n eps.
TEST(OnlineLearner, TargetsHaveMeanZeroAfterEveryFrame) {
  const auto learner = MakeLearner(OnlineSegmenterOptions::Paper().learner);
  for (int frame = 1; frame <= 4; ++frame) {
    LearnStreet(frame, *learner);
    const std::vector<double> targets = Targets(*learner);
    ASSERT_GT(targets.size(), 50u);
    const double sum = std::accumulate(targets.begin(), targets.end(), 0.0);
    EXPECT_NEAR(sum / static_cast<double>(targets.size()), 0.0, 1e-14);
    EXPECT_GT(learner->zero_label(), 0.05);
    EXPECT_LT(learner->zero_label(), 0.5);
  }
}

TEST(OnlineLearner, GoesOnFromACheckpointWithItsMeanLabel) {
  const OnlineLearnerOptions paper = OnlineSegmenterOptions::Paper().learner;
  const auto learner = MakeLearner(paper), restored = MakeLearner(paper);
  for (int frame = 1; frame <= 3; ++frame) LearnStreet(frame, *learner);
  auto checkpoint = Value(learner->Checkpoint());
  ASSERT_TRUE(restored->Restore(checkpoint).ok());
  EXPECT_EQ(restored->zero_label(), learner->zero_label());
  for (OnlineLearner* each : {learner.get(), restored.get()}) LearnStreet(4, *each);
  EXPECT_EQ(Targets(*restored), Targets(*learner));
  checkpoint.annotations.clear();
  EXPECT_THAT(restored->Restore(checkpoint), IsInvalid());
  EXPECT_EQ(Targets(*restored), Targets(*learner));
}

// What the budget has room for; when it is full, the share that one frame may bring.
TEST(OnlineLearner, TheFirstFrameFillsTheBudget) {
  OnlineLearnerOptions options = OnlineSegmenterOptions::Default().learner;
  options.SetDensity(0.0);
  options.budget = {500, 0.25};
  options.arrival_share = 0.2;
  const auto learner = MakeLearner(options);
  for (int frame = 1; frame <= 3; ++frame) {
    LearnStreet(frame, *learner);
    EXPECT_EQ(learner->model().size(), 500);
    int64_t arrived = 0;
    for (const int64_t birth : learner->model().birth_frames()) arrived += birth == frame;
    EXPECT_EQ(arrived, frame == 1 ? 500 : 100);
  }
}

TEST(OnlineLearner, TheZeroLabelIsChecked) {
  OnlineLearnerOptions options;
  for (const double wrong : {0.0, -0.1, 0.6, std::nan("")}) {
    options.zero_label = wrong;
    EXPECT_THAT(options.Validate().message(), testing::HasSubstr("zero_label"));
  }
}

}  // namespace
}  // namespace egosieve::vision
