// Four threads predict from one posterior while another conditions, reduces and frees models: every
// answer is that of the posterior alone, to the last bit. Under the thread sanitizer, no report.
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "egosieve/gaussian_process.hpp"
#include "gtest/gtest.h"

namespace egosieve {
namespace {

constexpr int kDimension = 2, kPoints = 60, kQueries = 90, kThreads = 4, kCalls = 12;

std::vector<double> Places(int count, double phase) {
  std::vector<double> places;
  for (int i = 0; i < count; ++i) {
    places.push_back(std::cos(1.3 * i + phase));
    places.push_back(std::sin(2.1 * i + phase));
  }
  return places;
}

std::vector<double> Values(const std::vector<double>& places) {
  std::vector<double> values;
  for (size_t i = 0; i < places.size(); i += 2) values.push_back(places[i] * places[i + 1]);
  return values;
}

GaussianProcess NewModel() {
  GaussianProcess gp = GaussianProcess::Create({.dimension = kDimension}).value();
  const std::vector<double> places = Places(kPoints, 0.0);
  gp.Condition({places, kDimension}, Values(places)).ThrowIfError();
  return gp;
}

TEST(Threads, PredictFromOnePosteriorWhileTheModelLearns) {
  GaussianProcess gp = NewModel();
  const Posterior posterior = gp.MakePosterior().value();
  const std::vector<double> queries = Places(kQueries, 0.5);
  std::vector<float> expected_mean(kQueries), expected_variance(kQueries);
  ASSERT_TRUE(posterior.Predict({queries, kDimension}, {expected_mean, expected_variance}).ok());

  std::atomic<int> wrong{0};
  std::vector<std::thread> predictors;
  for (int t = 0; t < kThreads; ++t) {
    predictors.emplace_back([&] {
      std::vector<float> mean(kQueries), variance(kQueries);
      for (int call = 0; call < kCalls; ++call) {
        const bool ok = posterior.Predict({queries, kDimension}, {mean, variance}).ok();
        wrong += !ok || mean != expected_mean || variance != expected_variance;
      }
    });
  }
  for (int step = 0; step < kCalls; ++step) {
    const std::vector<double> more = Places(5, 1.0 + step);
    EXPECT_TRUE(gp.Condition({more, kDimension}, Values(more)).ok());
    EXPECT_TRUE(gp.Remove({0, 2}).ok());
    std::vector<float> now(5);
    EXPECT_TRUE(gp.Predict({more, kDimension}, {now}).ok());
  }
  for (std::thread& predictor : predictors) predictor.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(gp.Describe()->size, kPoints + 3 * kCalls);
}

// Each thread has its own last error, and a handle that one thread frees under another's hands
// gives answers or InvalidHandle, nothing else.
TEST(Threads, FreeWhatOthersUse) {
  const std::vector<double> queries = Places(kQueries, 0.5);
  GaussianProcess gp = NewModel();
  egosieve_posterior* handle = nullptr;
  ASSERT_EQ(egosieve_gp_posterior(gp.handle(), &handle), EGOSIEVE_OK);
  std::atomic<int> answered{0}, strange{0};
  std::vector<std::thread> users;
  for (int t = 0; t < kThreads; ++t) {
    users.emplace_back([&, t] {
      std::vector<double> mean(kQueries);
      const ConstArray x(queries, kDimension);
      egosieve_prediction prediction;
      egosieve_prediction_init(&prediction);
      prediction.mean = Array(mean).c();
      for (;;) {
        const egosieve_status status = egosieve_posterior_predict(handle, x.c(), &prediction);
        if (status == EGOSIEVE_OK) {
          ++answered;
          continue;
        }
        const std::string text = egosieve_last_error();
        strange += status != EGOSIEVE_INVALID_HANDLE ||
                   text.find("posterior was freed") == std::string::npos;
        return;
      }
    });
  }
  while (answered < 2 * kThreads) std::this_thread::yield();
  EXPECT_EQ(egosieve_posterior_free(handle), EGOSIEVE_OK);
  for (std::thread& user : users) user.join();
  EXPECT_EQ(strange, 0);
}

}  // namespace
}  // namespace egosieve
