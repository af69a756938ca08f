// A posterior answers other threads while the model that made it goes on learning.
#include <atomic>
#include <thread>
#include <vector>

#include "gp/model/exact_model.h"
#include "gtest/gtest.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

TEST(PosteriorThreads, AnswersStayTheSameWhileTheModelLearns) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(300, 6, generator);
  const kernels::ConstMatrixView<double> x = ViewOf(points.inputs);
  const auto labels = absl::MakeConstSpan(points.labels);
  auto model = Value(ExactModel::Create(
      TestContext(), DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, 6)));
  ASSERT_TRUE(model.Add(x.rows_between(0, 150), labels.first(150), 0).ok());
  const auto posterior = Value(model.MakePosterior({1.5, 0.2}));
  const NarrowMatrix queries = RandomPoints(500, 6, generator).cast<float>();
  const auto evaluate = [&] {
    std::vector<float> values(1500);
    const auto counts = posterior->Evaluate(
        {queries.data(), 500, 6}, {values.data(), values.data() + 500, values.data() + 1000});
    return counts.ok() ? values : std::vector<float>();
  };
  const std::vector<float> expected = evaluate();
  ASSERT_EQ(expected.size(), 1500u);
  std::atomic<int> wrong{0};
  std::vector<std::thread> readers;
  for (int reader = 0; reader < 4; ++reader) {
    readers.emplace_back([&] {
      for (int round = 0; round < 5; ++round) wrong += evaluate() != expected;
    });
  }
  for (int64_t begin = 150; begin < 300; begin += 30) {
    EXPECT_TRUE(model.Add(x.rows_between(begin, begin + 30), labels.subspan(begin, 30), 1).ok());
    EXPECT_TRUE(model.Remove({0, 3, 17, 90}).ok());
  }
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace egosieve::gp
