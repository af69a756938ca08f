// A posterior on several devices: every query's result is that of one of them.
#include "kernels/ops/shared_posterior.h"

#include <CL/cl.h>

#include <limits>
#include <memory>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/runtime/context.h"
#include "tests/kernels/failing_calls.h"
#include "tests/kernels/ops/posterior_test.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

std::shared_ptr<Context> Open(const char* device) {
  ContextOptions options;
  options.device = device;
  return Value(OpenContext(options));
}

class SharedPosteriorTest : public testing::Test {
 protected:
  void SetUp() override {
    if (TestIsOnReference()) GTEST_SKIP() << "there is one device alone";
    problem_ = MakeProblem(random_, ArcsineParameters({1, 2, 3}), 30, 0.3);
  }
  std::unique_ptr<DensePosterior> Make(const std::vector<std::shared_ptr<Context>>& contexts) {
    return Value(CreateSharedPosterior(contexts, problem_.model(FactorKind::kCholesky)));
  }

  std::mt19937_64 random_ = TestRandom();
  Problem problem_;
};

// The first piece of each device is its own; which one computes the others is open.
TEST_F(SharedPosteriorTest, EveryDeviceHasItsPart) {
  const std::shared_ptr<Context> reference = Open("reference");
  const auto device = Make({TestContext()}), host = Make({reference}),
             shared = Make({TestContext(), reference});
  constexpr int64_t kQueries = 5 * 1024 + 17;
  const int64_t piece = SharedPiece(kQueries, 2);
  ASSERT_EQ(piece, 1024);
  const std::vector<float> queries = RandomQueries(random_, kQueries, 2);
  const ConstMatrixView<float> view(queries.data(), kQueries, 2);
  const std::vector<double> wide(queries.begin(), queries.end());
  Results of_device(kQueries), of_host(kQueries), of_both(kQueries), of_wide(kQueries);
  ASSERT_TRUE(device->Evaluate(view, of_device.outputs()).ok());
  ASSERT_TRUE(host->Evaluate(view, of_host.outputs()).ok());
  ASSERT_TRUE(shared->Evaluate(view, of_both.outputs()).ok());
  ASSERT_TRUE(shared->Evaluate({wide.data(), kQueries, 2}, of_wide.outputs()).ok());
  EXPECT_TRUE(of_both.guards_intact());
  int64_t different = 0;
  for (int64_t q = 0; q < kQueries; ++q) {
    const auto are = [&](const Results& found, const Results& one) {
      return found.mean(0, q) == one.mean(0, q) && found.variance(0, q) == one.variance(0, q) &&
             found.probability(0, q) == one.probability(0, q);
    };
    for (const Results* found : {&of_both, &of_wide}) {
      ASSERT_TRUE(are(*found, of_device) || are(*found, of_host)) << q;
      if (q < piece) {
        ASSERT_TRUE(are(*found, of_device)) << q;
      }
      if (q >= piece && q < 2 * piece) {
        ASSERT_TRUE(are(*found, of_host)) << q;
        different += are(*found, of_device) ? 0 : 1;
      }
    }
  }
  EXPECT_GT(different, 0);  // or the test could not tell them apart
}

TEST_F(SharedPosteriorTest, NothingIsWrittenWhereOneDeviceFails) {
  const auto shared = Make({TestContext(), Open("")});
  constexpr int64_t kQueries = 6000;
  const std::vector<float> queries = RandomQueries(random_, kQueries, 2);
  for (const int nth : {0, 1, 4}) {
    Results results(kQueries);
    FailCall("clEnqueueNDRangeKernel", nth, CL_OUT_OF_RESOURCES);
    const auto counts = shared->Evaluate({queries.data(), kQueries, 2}, results.outputs());
    EXPECT_TRUE(CallHasFailed());
    EXPECT_EQ(counts.status().code(), absl::StatusCode::kResourceExhausted);
    EXPECT_TRUE(results.mean.untouched() && results.variance.untouched());
  }
  Results results(kQueries);
  EXPECT_TRUE(shared->Evaluate({queries.data(), kQueries, 2}, results.outputs()).ok());
}

TEST_F(SharedPosteriorTest, RefusesWhatOneDeviceWould) {
  EXPECT_THAT(CreateSharedPosterior({}, problem_.model(FactorKind::kCholesky)), IsInvalid());
  EXPECT_THAT(
      CreateSharedPosterior({TestContext(), nullptr}, problem_.model(FactorKind::kCholesky)),
      IsInvalid());
  const auto shared = Make({TestContext(), TestContext()});
  EXPECT_EQ(shared->Enqueue({}, {}, {}).status().code(), absl::StatusCode::kFailedPrecondition);
  // On one device a posterior takes queues.
  const auto alone =
      Value(DensePosterior::Create(TestContext(), problem_.model(FactorKind::kCholesky)));
  EXPECT_EQ(Make({TestContext()})->Enqueue({}, {}, {}).status(),
            alone->Enqueue({}, {}, {}).status());
  constexpr int64_t kQueries = 3000;
  std::vector<float> queries = RandomQueries(random_, kQueries, 2);
  queries[2 * 2500] = std::numeric_limits<float>::quiet_NaN();
  Results results(kQueries);
  const absl::Status refused =
      shared->Evaluate({queries.data(), kQueries, 2}, results.outputs()).status();
  EXPECT_THAT(refused, IsInvalid());
  EXPECT_THAT(refused.ToString(), testing::HasSubstr("2500"));
  EXPECT_TRUE(results.mean.untouched());
  EXPECT_TRUE(shared->Evaluate({queries.data(), 0, 2}, results.outputs()).ok());
}

}  // namespace
}  // namespace egosieve::kernels
