// A device that fails late in a prediction of several pieces, or one of several devices: nothing has
// been written by then.
#include <CL/cl.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/kernels/failing_calls.h"
#include "tools/embed/include/egosieve/device_call.h"
#include "tools/embed/include/egosieve/gaussian_process.h"

namespace egosieve {
namespace {

constexpr int64_t kQueries = 3 * (int64_t{1} << 16);  // tools/embed/c/prediction.cc: three pieces
constexpr double kUntouched = -7.0;

egosieve_const_array Input(const std::vector<double>& values) {
  return {.data = values.data(),
          .rows = static_cast<int64_t>(values.size()),
          .columns = 1,
          .type = EGOSIEVE_FLOAT64};
}

egosieve_array Output(std::vector<double>& values) {
  return {.data = values.data(),
          .rows = static_cast<int64_t>(values.size()),
          .columns = 1,
          .type = EGOSIEVE_FLOAT64};
}

// Null on the reference, which calls no driver.
egosieve_gp* NewModel() {
  const char* device = std::getenv("EGOSIEVE_DEVICE");
  if (device != nullptr && std::string(device) == "reference") return nullptr;
  egosieve_gp_options options;
  egosieve_gp_options_init(&options);
  options.dimension = 1;
  egosieve_gp* gp = nullptr;
  EXPECT_EQ(egosieve_gp_create(&options, &gp), EGOSIEVE_OK);
  const std::vector<double> x = {0.0, 0.5, 1.0}, y = {0.0, 1.0, -1.0};
  const egosieve_const_array inputs = Input(x), targets = Input(y);
  EXPECT_EQ(egosieve_gp_condition(gp, &inputs, &targets), EGOSIEVE_OK) << egosieve_last_error();
  return gp;
}

// Every `step`-th launch of a kernel fails, one in each call of `predict`, until none does. Returns
// the failures.
template <typename Predict>
int ExpectNothingWritten(int step, const Predict& predict) {
  std::vector<double> queries(kQueries);
  for (int64_t i = 0; i < kQueries; ++i) queries[i] = static_cast<double>(i) / kQueries;
  const egosieve_const_array places = Input(queries);
  int failures = 0;
  for (int nth = 0;; nth += step) {
    SCOPED_TRACE(nth);
    std::vector<double> mean(kQueries, kUntouched), variance(kQueries, kUntouched);
    egosieve_prediction prediction;
    egosieve_prediction_init(&prediction);
    prediction.mean = Output(mean);
    prediction.variance = Output(variance);
    prediction.clamped_variances = -7;
    kernels::FailCall("clEnqueueNDRangeKernel", nth, CL_DEVICE_NOT_AVAILABLE);
    const egosieve_status status = predict(&places, &prediction);
    if (!kernels::CallHasFailed()) {
      EXPECT_EQ(status, EGOSIEVE_OK);
      EXPECT_EQ(std::count(mean.begin(), mean.end(), kUntouched), 0);
      return failures;
    }
    ++failures;
    EXPECT_EQ(status, EGOSIEVE_UNAVAILABLE);
    EXPECT_EQ(std::count(mean.begin(), mean.end(), kUntouched), kQueries);
    EXPECT_EQ(std::count(variance.begin(), variance.end(), kUntouched), kQueries);
    EXPECT_EQ(prediction.clamped_variances, -7);
  }
}

TEST(PredictionFailure, WritesNothingHoweverLateItComes) {
  egosieve_gp* gp = NewModel();
  if (gp == nullptr) GTEST_SKIP() << "the reference calls no driver";
  EXPECT_GE(ExpectNothingWritten(1,
                                 [&](const auto* places, auto* prediction) {
                                   return egosieve_gp_predict(gp, places, prediction);
                                 }),
            3)
      << "the prediction was no longer in pieces";
  EXPECT_EQ(egosieve_gp_free(gp), EGOSIEVE_OK);
}

TEST(PredictionFailure, OfOneOfSeveralDevicesWritesNothing) {
  egosieve_gp* gp = NewModel();
  if (gp == nullptr) GTEST_SKIP() << "the reference calls no driver";
  const char* devices[] = {"", ""};
  egosieve_posterior* posterior = nullptr;
  ASSERT_EQ(egosieve_gp_posterior_on_devices(gp, devices, 2, &posterior), EGOSIEVE_OK)
      << egosieve_last_error();
  // kernels/ops/shared_posterior.cc: sixteen pieces for each of the three.
  EXPECT_GE(ExpectNothingWritten(13,
                                 [&](const auto* places, auto* prediction) {
                                   return egosieve_posterior_predict(posterior, places, prediction);
                                 }),
            3);
  EXPECT_EQ(egosieve_posterior_free(posterior), EGOSIEVE_OK);
  EXPECT_EQ(egosieve_gp_free(gp), EGOSIEVE_OK);
}

}  // namespace
}  // namespace egosieve
