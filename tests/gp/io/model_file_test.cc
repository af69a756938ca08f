#include "gp/io/model_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "gp/io/array_file.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

std::vector<std::string> FilesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  return names;
}

struct Learner {
  ExactModel model;
  HyperparameterTrainer trainer;
  SquashParameters squash{1.0, 0.0};
};

Learner MakeLearner() {
  const Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 6);
  const TrainerOptions options{.subset_size = 100, .annealing_evaluations = 10};
  return {*ExactModel::Create(TestContext(), theta),
          *HyperparameterTrainer::Create(
              theta, HyperparameterBounds::Default(CovarianceFunction::kArcsine, 6), options)};
}

ModelFile NoisyFile() {
  ModelFile file;
  file.model.hyperparameters = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  file.model.hyperparameters.mean = MeanFunction::kLinear;
  const std::vector<double> x = {0.1, 0.2, 0.3, 0.4, 0.5, 0.9}, y = {1, 2, 3, 4, 5, 6};
  file.model.points.Append({{x.data(), 3, 2}, {y.data(), 3, 2}, {0.5, 0.0, 0.25}}, 4);
  return file;
}

TEST(ModelFile, HoldsNoiseByPointOutputsAndTheMean) {
  const ModelFile file = NoisyFile();
  const auto bytes = Value(SerializeModel(file));
  const auto back = Value(ParseModel(bytes));
  EXPECT_EQ(back.model.points.outputs, 2);
  EXPECT_EQ(back.model.points.targets, file.model.points.targets);
  EXPECT_EQ(back.model.points.noise_variances, file.model.points.noise_variances);
  EXPECT_EQ(back.model.hyperparameters.mean, MeanFunction::kLinear);
  EXPECT_EQ(*SerializeModel(back), bytes);
}

TEST(ModelFile, HoldsWhatASparseModelIs) {
  ModelFile file = NoisyFile();
  for (const SparseApproximation approximation :
       {SparseApproximation::kDtc, SparseApproximation::kFitc}) {
    file.sparse = SparseModelOptions{};
    file.sparse->approximation = approximation;
    file.sparse->inducing_points = 37;
    const auto bytes = Value(SerializeModel(file));
    const auto read = Value(ParseModel(bytes));
    ASSERT_TRUE(read.sparse.has_value());
    EXPECT_EQ(read.sparse->approximation, approximation);
    EXPECT_EQ(read.sparse->inducing_points, 37);
  }
  file.sparse->inducing_points = 0;
  EXPECT_THAT(SerializeModel(file), IsInvalid());
}

TEST(ModelFile, HoldsWhatAnIterativeModelIs) {
  ModelFile file = NoisyFile();
  file.model.hyperparameters.mean = MeanFunction::kZero;
  file.iterative = IterativeFile{{}, {0.5, -1.0, 2.0, 3.0, 0.25, 7.0}};
  file.iterative->options.rank = 37;
  file.iterative->options.gradients.tolerance = 1e-5;
  const auto bytes = Value(SerializeModel(file));
  const auto back = Value(ParseModel(bytes));
  ASSERT_TRUE(back.iterative.has_value());
  EXPECT_EQ(back.iterative->options.rank, 37);
  EXPECT_EQ(back.iterative->options.gradients.tolerance, 1e-5);
  EXPECT_EQ(back.iterative->alpha, file.iterative->alpha);
  EXPECT_EQ(*SerializeModel(back), bytes);
  const auto with = [&](const char* name, std::vector<double> elements) {
    auto arrays = ParseArrays(bytes);
    (*arrays)[name] = VectorArray(std::move(elements));
    return ParseModel(*SerializeArrays(*arrays)).status();
  };
  EXPECT_EQ(with("alpha", {0.5}).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(with("iterative", {0.0, 1e-5}).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(with("iterative", {37.0}).code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(with("iterative", {37.0, 0.0}), IsInvalid("tolerance"));
  file.iterative->options.rank = 0;
  EXPECT_THAT(SerializeModel(file), IsInvalid("rank"));
}

// Older programs read what they can: a file without any of these is of version 1.
TEST(ModelFile, IsOfTheEarliestVersionThatHoldsIt) {
  const auto version = [](const ModelFile& file) {
    auto arrays = ParseArrays(*SerializeModel(file));
    return std::get<std::vector<int64_t>>((*arrays)["format_version"].elements)[0];
  };
  ModelFile file = NoisyFile();
  EXPECT_EQ(version(file), 2);
  file.model.hyperparameters.mean = MeanFunction::kZero;
  file.model.points.noise_variances.clear();
  EXPECT_EQ(version(file), 2);
  file.model.points.targets.resize(3);
  file.model.points.outputs = 1;
  EXPECT_EQ(version(file), 1);
  file.sparse = SparseModelOptions{};
  EXPECT_EQ(version(file), 3);
  file.sparse.reset();
  file.iterative = IterativeFile{{}, {1.0, 2.0, 3.0}};
  EXPECT_EQ(version(file), 5);
  file.is_normalized = true;
  EXPECT_EQ(version(file), 6);
  EXPECT_TRUE(ParseModel(*SerializeModel(file), true)->is_normalized);
  EXPECT_EQ(ParseModel(*SerializeModel(file)).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(ModelFile, RefusesBadOutputsNoiseAndMeans) {
  const auto with = [](const char* name, NamedArray array) {
    auto arrays = ParseArrays(*SerializeModel(NoisyFile()));
    (*arrays)[name] = std::move(array);
    return ParseModel(*SerializeArrays(*arrays)).status().code();
  };
  EXPECT_EQ(with("mean_function", {{1}, std::vector<int64_t>{3}}), absl::StatusCode::kDataLoss);
  EXPECT_EQ(with("sparse", {{2}, std::vector<int64_t>{3, 10}}), absl::StatusCode::kDataLoss);
  EXPECT_EQ(with("sparse", {{2}, std::vector<int64_t>{1, 0}}), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(with("noise_variances", {{3}, std::vector<double>{0.1, -1.0, 0.1}}),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(with("noise_variances", {{1}, std::vector<double>{0.1}}),
            absl::StatusCode::kInvalidArgument);
  EXPECT_NE(with("targets", {{3, 0}, std::vector<double>{}}), absl::StatusCode::kOk);
  EXPECT_NE(with("targets", {{2, 4}, std::vector<double>(8, 1.0)}), absl::StatusCode::kOk);
}

// A step of learning: points in, points out, a training step, a rebuild, calibration.
void Learn(int64_t time, Learner& learner) {
  std::mt19937_64 generator(time);
  const LabelledPoints points = NoisyBlobs(60, 6, generator);
  ASSERT_TRUE(learner.model.Add(ViewOf(points.inputs), points.labels, time).ok());
  if (learner.model.size() > 150) {
    ASSERT_TRUE(learner.model.Remove(RandomRows(learner.model.size(), 40, generator)).ok());
  }
  ASSERT_TRUE(learner.trainer.Train(*TestContext(), learner.model.observations()).ok());
  if (learner.trainer.ShouldRebuild(learner.model.hyperparameters())) {
    ASSERT_TRUE(learner.model.SetHyperparameters(learner.trainer.hyperparameters()).ok());
  }
  const auto left_out = Value(learner.model.PredictLeaveOneOut());
  std::vector<double> labels;
  for (const double y : learner.model.targets()) labels.push_back(0.5 * (y + 1.0));
  learner.squash = Value(FitSquash(
      left_out.mean, left_out.LatentVariance(learner.model.hyperparameters().noise_variance()),
      labels, learner.squash));
}

ModelFile Checkpoint(const Learner& learner) {
  return {learner.model.State(), learner.squash, learner.trainer.state(), "frame 7\0of 9"};
}

TEST(ModelFile, ARunGoesOnFromItsCheckpointBitForBit) {
  const std::string path = FreshFolder() + "/model.npz";
  Learner whole = MakeLearner();
  for (int64_t time = 0; time < 6; ++time) Learn(time, whole);
  ASSERT_TRUE(whole.model.Refactorize().ok());
  ASSERT_TRUE(WriteModelFile(path, Checkpoint(whole)).ok());

  const auto file = Value(ReadModelFile(path));
  Learner resumed = MakeLearner();
  resumed.model = *ExactModel::Restore(TestContext(), file.model);
  ASSERT_TRUE(resumed.trainer.Restore(*file.trainer).ok());
  resumed.squash = file.squash;
  EXPECT_EQ(CopyOf(resumed.model.factor().Factor()), CopyOf(whole.model.factor().Factor()));
  for (int64_t time = 6; time < 11; ++time) {
    Learn(time, whole);
    Learn(time, resumed);
  }
  EXPECT_EQ(*SerializeModel(Checkpoint(whole)), *SerializeModel(Checkpoint(resumed)));
  EXPECT_EQ(CopyOf(resumed.model.factor().Factor()), CopyOf(whole.model.factor().Factor()));
  EXPECT_EQ(resumed.model.alpha(), whole.model.alpha());
}

TEST(ModelFile, KeepsEverything) {
  Learner learner = MakeLearner();
  Learn(0, learner);
  const ModelFile before = Checkpoint(learner);
  const auto after = Value(ParseModel(*SerializeModel(before)));
  EXPECT_EQ(after.model.points.inputs, before.model.points.inputs);
  EXPECT_EQ(after.model.points.identities, before.model.points.identities);
  EXPECT_EQ(after.model.points.next_identity, 60);
  EXPECT_EQ(after.annotations, before.annotations);
  EXPECT_EQ(after.trainer->theta, before.trainer->theta);
  EXPECT_FALSE(after.trainer->smoothed_objective.has_value());
  ModelFile settled = before;
  settled.trainer->smoothed_objective = -0.5;
  EXPECT_EQ(ParseModel(*SerializeModel(settled))->trainer->smoothed_objective, -0.5);
  ModelFile without = before;
  without.trainer.reset();
  without.model.hyperparameters =
      DefaultHyperparameters(CovarianceFunction::kSquaredExponential, 6);
  const auto other = Value(ParseModel(*SerializeModel(without)));
  EXPECT_FALSE(other.trainer.has_value());
  EXPECT_EQ(other.model.hyperparameters.covariance.function,
            CovarianceFunction::kSquaredExponential);
  ModelFile named = without;
  named.model.hyperparameters =
      DefaultHyperparameters(*CovarianceFunction::Parse("isotropic(matern52) + linear[0,2]"), 6);
  const auto composed = Value(ParseModel(*SerializeModel(named)));
  EXPECT_EQ(composed.model.hyperparameters.covariance.function,
            named.model.hyperparameters.covariance.function);
  EXPECT_EQ(composed.model.hyperparameters.covariance.input_dimension(), 6);
  const Learner empty = MakeLearner();
  EXPECT_TRUE(ParseModel(*SerializeModel(Checkpoint(empty))).ok());
}

TEST(ModelFile, OtherVersionsAndInvalidModelsAreErrors) {
  Learner learner = MakeLearner();
  Learn(0, learner);
  const auto altered = [&](auto change) {
    ArrayMap arrays = *ParseArrays(*SerializeModel(Checkpoint(learner)));
    change(arrays);
    return ParseModel(*SerializeArrays(arrays)).status();
  };
  const auto doubles = [](ArrayMap& arrays, const char* name) -> std::vector<double>& {
    return std::get<std::vector<double>>(arrays[name].elements);
  };
  const auto integers = [](ArrayMap& arrays, const char* name) -> std::vector<int64_t>& {
    return std::get<std::vector<int64_t>>(arrays[name].elements);
  };
  EXPECT_TRUE(altered([](ArrayMap&) {}).ok());
  const absl::Status newer =
      altered([&](ArrayMap& a) { integers(a, "format_version")[0] = kModelFormatVersion + 1; });
  EXPECT_THAT(newer, IsError(absl::StatusCode::kUnimplemented, "newer"));
  for (const char* name : {"scales", "inputs", "targets", "identities", "squash", "annotations",
                           "trainer_steps", "format_version"}) {
    EXPECT_FALSE(altered([&](ArrayMap& a) { a.erase(name); }).ok()) << name;
    EXPECT_FALSE(altered([&](ArrayMap& a) {
                   a[name] = {{1}, std::vector<uint8_t>{7}};
                 }).ok() &&
                 std::string(name) != "annotations")
        << name;
  }
  EXPECT_FALSE(altered([&](ArrayMap& a) { doubles(a, "inputs")[3] = std::nan(""); }).ok());
  EXPECT_FALSE(altered([&](ArrayMap& a) { doubles(a, "targets")[3] = INFINITY; }).ok());
  EXPECT_FALSE(altered([&](ArrayMap& a) { doubles(a, "scales")[0] = -1.0; }).ok());
  EXPECT_FALSE(altered([&](ArrayMap& a) { doubles(a, "signal_noise")[1] = 0.0; }).ok());
  EXPECT_FALSE(altered([&](ArrayMap& a) { doubles(a, "squash")[0] = 0.0; }).ok());
  EXPECT_FALSE(altered([&](ArrayMap& a) { integers(a, "identities")[5] = 2; }).ok());
  EXPECT_FALSE(altered([&](ArrayMap& a) { integers(a, "next_identity")[0] = 10; }).ok());
  EXPECT_FALSE(altered([&](ArrayMap& a) {
                 integers(a, "next_identity")[0] = std::numeric_limits<int64_t>::max();
               }).ok());
  EXPECT_FALSE(altered([&](ArrayMap& a) { integers(a, "covariance_function")[0] = 9; }).ok());

  ModelFile bad = Checkpoint(learner);
  bad.model.points.targets.pop_back();
  const std::string folder = FreshFolder();
  EXPECT_THAT(WriteModelFile(folder + "/m.npz", bad), IsInvalid());
  EXPECT_THAT(FilesIn(folder), testing::IsEmpty());
}

TEST(ModelFile, WhatCannotBeReadIsAnError) {
  const std::string folder = FreshFolder();
  EXPECT_EQ(ReadModelFile(folder + "/none").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ReadModelFile(folder).status().code(), absl::StatusCode::kFailedPrecondition);
  const std::string pipe = folder + "/pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(ReadModelFile(pipe).status().code(), absl::StatusCode::kFailedPrecondition);
  const std::string path = folder + "/m.npz";
  std::ofstream(path) << "not a model";
  const absl::Status status = ReadModelFile(path).status();
  EXPECT_THAT(status, IsError(absl::StatusCode::kDataLoss, path));
  // A sparse file of 4 TiB: refused by its size, unread.
  std::filesystem::resize_file(path, std::uintmax_t{4} << 40);
  EXPECT_EQ(ReadModelFile(path).status().code(), absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace egosieve::gp
