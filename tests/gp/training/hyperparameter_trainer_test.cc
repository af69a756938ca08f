#include "gp/training/hyperparameter_trainer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gp/training/marginal_likelihood.h"
#include "gp/training/trainer_steps.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

constexpr CovarianceFunction kArcsine = CovarianceFunction::kArcsine;

HyperparameterTrainer MakeTrainer(const TrainerOptions& options, int64_t dimension = 3) {
  return Value(HyperparameterTrainer::Create(DefaultHyperparameters(kArcsine, dimension),
                                             HyperparameterBounds::Default(kArcsine, dimension),
                                             options));
}

TrainerOptions QuickOptions() {
  return {.subset_size = 150, .annealing_subset_size = 80, .annealing_evaluations = 40};
}

double MeanLikelihood(const Hyperparameters& theta, const LabelledPoints& points) {
  const auto value = Value(ComputeMarginalLikelihood(
      *TestContext(), theta, {ViewOf(points.inputs), points.targets()}, LikelihoodOrder::kValue));
  return value.value / static_cast<double>(points.labels.size());
}

TEST(SimulatedAnnealing, LeavesTheLocalMaximum) {
  // A broad local maximum of 0.1 at -2 and a narrower global one of 0.2 at 3; 0.3 wide.
  const auto objective = [](const std::vector<double>& t) -> absl::StatusOr<double> {
    return 0.1 * std::exp(-0.5 * (t[0] + 2.0) * (t[0] + 2.0)) +
           0.2 * std::exp(-0.5 * (t[0] - 3.0) * (t[0] - 3.0) / 0.09);
  };
  const auto anneal = [&](uint64_t seed) {
    return Value(Anneal(objective, {-2.0}, {{-5.0}, {5.0}}, 300, seed));
  };
  const std::vector<double> theta = anneal(1);
  EXPECT_NEAR(theta[0], 3.0, 0.3);
  EXPECT_EQ(theta, anneal(1));
  EXPECT_NE(theta, anneal(2));
}

TEST(SimulatedAnnealing, NeverAcceptsWhatIsNoNumber) {
  const auto objective = [](const std::vector<double>& t) -> absl::StatusOr<double> {
    return t[0] > 0.0 ? std::nan("") : -t[0] * t[0];
  };
  const auto theta = Value(Anneal(objective, {-4.0}, {{-5.0}, {5.0}}, 150, 1));
  EXPECT_LE(theta[0], 0.0);
  EXPECT_GT(theta[0], -1.0);
}

TEST(HyperparameterTrainer, RaisesTheLikelihoodAndSettles) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(400, 3, generator);
  HyperparameterTrainer trainer = MakeTrainer(QuickOptions());
  const double before = MeanLikelihood(trainer.hyperparameters(), points);
  const Hyperparameters start = trainer.hyperparameters();
  for (int round = 0; round < 60; ++round) {
    ASSERT_TRUE(trainer.Train(*TestContext(), {ViewOf(points.inputs), points.targets()}).ok());
  }
  EXPECT_GT(MeanLikelihood(trainer.hyperparameters(), points), before + 0.02);
  EXPECT_TRUE(trainer.ShouldRebuild(start));
  EXPECT_FALSE(trainer.ShouldRebuild(trainer.hyperparameters()));
  EXPECT_EQ(trainer.state().rounds, 60);
}

TrainerOptions SettledOptions() {
  TrainerOptions options = QuickOptions();
  options.settled_movement = 1e9;  // settled from the second round on
  options.settled_interval = 4;
  return options;
}

void ExpectSettled(const LabelledPoints& points, HyperparameterTrainer& trainer) {
  for (int round = 0; round < 9; ++round) {
    const std::vector<double> before = trainer.state().theta;
    ASSERT_TRUE(trainer.Train(*TestContext(), {ViewOf(points.inputs), points.targets()}).ok());
    EXPECT_EQ(trainer.state().rounds_since_step, round % 4);
    EXPECT_EQ(trainer.state().theta != before, round % 4 == 0);
  }
}

TEST(HyperparameterTrainer, DoesLessWhenSettledAndNoticesChange) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(200, 3, generator);
  TrainerOptions options = SettledOptions();
  options.subset_size = options.annealing_subset_size = 200;  // all: no sampling noise in J
  HyperparameterTrainer trainer = MakeTrainer(options);
  ExpectSettled(points, trainer);
  // Labels that are noise now: the objective falls, and it takes steps at once.
  LabelledPoints changed = points;
  for (double& label : changed.labels) label = generator() % 2 == 0 ? 0.0 : 1.0;
  ASSERT_TRUE(trainer.Train(*TestContext(), {ViewOf(changed.inputs), changed.targets()}).ok());
  EXPECT_EQ(trainer.state().rounds_since_step, 0);
}

// Two places, half of the points at each: J depends on how many points there are and hardly on
// which.
LabelledPoints TwoPlaces(int64_t count) {
  LabelledPoints points{.inputs = RowMatrix::Constant(count, 3, -0.5)};
  points.inputs.topRows(count / 2).setConstant(0.5);
  points.labels.assign(count, 0.0);
  std::fill_n(points.labels.begin(), count / 2, 1.0);
  return points;
}

TEST(HyperparameterTrainer, ChecksOfFewPointsAreNotComparedWithStepsOfMany) {
  const LabelledPoints points = TwoPlaces(400);
  TrainerOptions options = SettledOptions();
  options.subset_size = 400;
  options.annealing_subset_size = 20;
  HyperparameterTrainer trainer = MakeTrainer(options);
  ExpectSettled(points, trainer);
}

TEST(HyperparameterTrainer, AnIndefiniteFrameIsForgotten) {
  Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kSquaredExponential, 3);
  theta.covariance.scales.assign(3, 0.05);  // K = I nearly where no two points are alike
  theta.noise_stddev = 1e-9;                // and singular where two are
  const HyperparameterBounds here{ToLogarithms(theta), ToLogarithms(theta)};
  TrainerOptions options = QuickOptions();
  options.settled_movement = 1e9;
  auto trainer = Value(HyperparameterTrainer::Create(theta, here, options));
  auto generator = TestGenerator();
  const LabelledPoints apart = NoisyBlobs(60, 3, generator);
  const LabelledPoints alike = TwoPlaces(60);
  const auto train = [&](const LabelledPoints& points) {
    ASSERT_TRUE(trainer.Train(*TestContext(), {ViewOf(points.inputs), points.targets()}).ok());
  };
  for (int round = 0; round < 3; ++round) train(apart);
  ASSERT_TRUE(trainer.state().smoothed_objective.has_value());
  for (int round = 0; round < 3; ++round) train(alike);
  EXPECT_TRUE(trainer.Restore(trainer.state()).ok());
  train(apart);
  ASSERT_TRUE(trainer.state().smoothed_objective.has_value());
  EXPECT_TRUE(std::isfinite(*trainer.state().smoothed_objective));
  EXPECT_TRUE(trainer.Restore(trainer.state()).ok());
}

TEST(HyperparameterTrainer, GoesOnFromItsStateBitForBit) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(300, 3, generator);
  const auto train = [&](HyperparameterTrainer& trainer, int rounds) {
    for (int round = 0; round < rounds; ++round) {
      ASSERT_TRUE(trainer.Train(*TestContext(), {ViewOf(points.inputs), points.targets()}).ok());
    }
  };
  HyperparameterTrainer whole = MakeTrainer(QuickOptions());
  train(whole, 3);
  HyperparameterTrainer resumed = MakeTrainer(QuickOptions());
  ASSERT_TRUE(resumed.Restore(whole.state()).ok());
  train(whole, 4);
  train(resumed, 4);
  EXPECT_EQ(whole.state().theta, resumed.state().theta);
  EXPECT_EQ(whole.state().optimiser.steps, resumed.state().optimiser.steps);
  EXPECT_EQ(whole.state().smoothed_objective, resumed.state().smoothed_objective);
  TrainerOptions other = QuickOptions();
  other.seed = 5;
  HyperparameterTrainer different = MakeTrainer(other);
  train(different, 3);
  EXPECT_NE(different.state().theta, whole.state().theta);
}

TEST(HyperparameterTrainer, LearnsNothingFromTooLittle) {
  HyperparameterTrainer trainer = MakeTrainer(QuickOptions());
  auto generator = TestGenerator();
  LabelledPoints points = NoisyBlobs(10, 3, generator);
  EXPECT_TRUE(trainer.Train(*TestContext(), {ViewOf(points.inputs), points.targets()}).ok());
  points = NoisyBlobs(100, 3, generator);
  points.labels.assign(100, 0.2);
  EXPECT_TRUE(trainer.Train(*TestContext(), {ViewOf(points.inputs), points.targets()}).ok());
  EXPECT_TRUE(
      trainer.Train(*TestContext(), {ViewOf(RowMatrix(0, 3)), absl::Span<const double>()}).ok());
  EXPECT_EQ(trainer.state().rounds, 0);
  EXPECT_EQ(ToLogarithms(trainer.hyperparameters()),
            ToLogarithms(DefaultHyperparameters(kArcsine, 3)));
}

TEST(HyperparameterTrainer, RefusesBadOptionsAndStates) {
  const Hyperparameters theta = DefaultHyperparameters(kArcsine, 3);
  const HyperparameterBounds bounds = HyperparameterBounds::Default(kArcsine, 3);
  const auto refuses = [&](auto change) {
    TrainerOptions options;
    change(options);
    return HyperparameterTrainer::Create(theta, bounds, options).status().code() ==
           absl::StatusCode::kInvalidArgument;
  };
  EXPECT_TRUE(refuses([](TrainerOptions& o) { o.subset_size = 0; }));
  EXPECT_TRUE(refuses([](TrainerOptions& o) { o.minimum_class_share = 0.6; }));
  EXPECT_TRUE(refuses([](TrainerOptions& o) { o.minimum_class_share = std::nan(""); }));
  EXPECT_TRUE(refuses([](TrainerOptions& o) { o.prior_stddev = 0.0; }));
  EXPECT_TRUE(refuses([](TrainerOptions& o) { o.rebuild_threshold = std::nan(""); }));
  EXPECT_FALSE(
      HyperparameterTrainer::Create(theta, HyperparameterBounds::Default(kArcsine, 4)).ok());

  HyperparameterTrainer trainer = MakeTrainer(QuickOptions());
  const auto refuses_state = [&](auto change) {
    TrainerState state = trainer.state();
    change(state);
    return trainer.Restore(state).code() == absl::StatusCode::kInvalidArgument;
  };
  EXPECT_TRUE(refuses_state([](TrainerState& s) { s.theta.pop_back(); }));
  EXPECT_TRUE(refuses_state([](TrainerState& s) { s.theta[0] = 100.0; }));
  EXPECT_TRUE(refuses_state([](TrainerState& s) { s.theta[1] = std::nan(""); }));
  EXPECT_TRUE(refuses_state([](TrainerState& s) { s.optimiser.steps = {0.1}; }));
  EXPECT_TRUE(refuses_state([](TrainerState& s) { s.rounds = -1; }));
  EXPECT_TRUE(refuses_state([](TrainerState& s) { s.smoothed_objective = std::nan(""); }));
}

}  // namespace
}  // namespace egosieve::gp
