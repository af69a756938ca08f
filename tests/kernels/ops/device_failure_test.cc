// Devices that run out of memory or vanish: every OpenCL call of every operation fails in turn. The
// operation says which call failed, writes nothing, and works when it is asked again.
#include <CL/opencl.hpp>
#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/ops/exact_regression.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/kernels/failing_calls.h"
#include "tests/kernels/ops/posterior_test.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

template <typename T>
using OutputsOf = std::vector<GuardedMatrix<T>>;
using Outputs = OutputsOf<float>;

// Whether a call comes after the kernel was started.
bool IsAfterTheStart(const std::string& call) {
  return call == "clEnqueueMapBuffer" || call == "clEnqueueUnmapMemObject" ||
         call == "clEnqueueReadBuffer" || call == "clFinish";
}

template <typename T>
void ExpectSame(const OutputsOf<T>& actual, const OutputsOf<T>& expected, int64_t size) {
  for (size_t o = 0; o < expected.size(); ++o) {
    EXPECT_TRUE(actual[o].guards_intact());
    for (int64_t i = 0; i < size; ++i)
      ASSERT_EQ(actual[o](0, i), expected[o](0, i)) << o << " " << i;
  }
}

class DeviceFailureTest : public testing::Test {
 protected:
  void SetUp() override {
    if (TestIsOnReference()) GTEST_SKIP() << "the reference calls no driver";
  }
  void TearDown() override { CallHasFailed(); }

  // `operation` fills `outputs` matrices of 1 x size. staged: not even a failure after the kernel's
  // start leaves anything in them.
  template <typename T = float>
  void FailEveryCall(
      const std::type_identity_t<std::function<absl::Status(OutputsOf<T>&)>>& operation,
      int outputs, int64_t size, bool staged) {
    const OutputsOf<T> empty(outputs, GuardedMatrix<T>(1, size));
    OutputsOf<T> expected = empty;
    // With nothing that earlier calls left in the contexts.
    const auto run = [&](OutputsOf<T>& out) {
      TestContext()->ReleaseIdle();
      SideBySideContext()->ReleaseIdle();
      return operation(out);
    };
    ASSERT_EQ(run(expected), absl::OkStatus());
    std::set<std::string> exercised;
    for (const std::string& call : FailingCalls()) {
      constexpr int kManyCalls = 1000;
      for (int nth = 0; nth < kManyCalls; ++nth) {
        SCOPED_TRACE(testing::Message() << call << " number " << nth);
        OutputsOf<T> actual = empty;
        const bool lost = nth % 2 == 1;
        FailCall(call, nth, lost ? CL_DEVICE_NOT_AVAILABLE : CL_OUT_OF_RESOURCES);
        const absl::Status status = run(actual);
        if (!CallHasFailed()) break;  // there are no more such calls
        if (status.ok()) {
          // A wait that only makes sure of what has ended.
          ASSERT_EQ(call, "clFinish");
          ExpectSame<T>(actual, expected, size);
          continue;
        }
        exercised.insert(call);
        EXPECT_EQ(status.code(),
                  lost ? absl::StatusCode::kUnavailable : absl::StatusCode::kResourceExhausted);
        EXPECT_TRUE(
            absl::StrContains(absl::AsciiStrToLower(status.message()), absl::AsciiStrToLower(call)))
            << status;
        for (const GuardedMatrix<T>& output : actual) {
          EXPECT_TRUE(output.guards_intact());
          if (staged || !IsAfterTheStart(call)) {
            EXPECT_TRUE(output.untouched());
          }
        }
        OutputsOf<T> again = empty;
        ASSERT_EQ(run(again), absl::OkStatus());
        ExpectSame<T>(again, expected, size);
        ASSERT_LT(nth, kManyCalls - 1);
      }
    }
    for (const char* call : {"clCreateKernel", "clCreateCommandQueue", "clCreateBuffer",
                             "clSetKernelArg", "clEnqueueNDRangeKernel", "clFinish"}) {
      EXPECT_EQ(exercised.count(call), 1u) << call << " never failed";
    }
  }

  std::mt19937_64 random_ = TestRandom();
};

TEST_F(DeviceFailureTest, TheDefaultCapHoldsThousandsOfQueriesAtOnce) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 2, 3}), 50, 0.3);
  const auto posterior = Value(DensePosterior::Create(
      TestContext(), problem.model(FactorKind::kCholesky), DensePosteriorOptions()));
  constexpr int64_t kQueries = 5000;
  const std::vector<float> queries = RandomQueries(random_, kQueries, 2);
  std::vector<float> mean(kQueries);
  const PosteriorOutputs outputs{.mean = mean.data()};
  FailCall("clEnqueueNDRangeKernel", 1, CL_OUT_OF_RESOURCES);  // the second start of the kernel
  EXPECT_TRUE(posterior->Evaluate({queries.data(), kQueries, 2, 2}, outputs).ok());
  EXPECT_FALSE(CallHasFailed());
}

TEST_F(DeviceFailureTest, DensePosterior) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 2, 3}), 50, 0.3);
  // A tile at a time: calls fail when others have succeeded.
  const auto posterior = Value(DensePosterior::Create(
      TestContext(), problem.model(FactorKind::kCholesky), {.memory_cap_bytes = 1}));
  constexpr int64_t kQueries = 130;
  const std::vector<float> queries = RandomQueries(random_, kQueries, 2);
  FailEveryCall(
      [&](Outputs& out) {
        return posterior
            ->Evaluate(ConstMatrixView<float>(queries.data(), kQueries, 2),
                       {out[0].data(), out[1].data(), out[2].data()})
            .status();
      },
      3, kQueries, /*staged=*/true);
}

TEST_F(DeviceFailureTest, CreationOfADensePosterior) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 2, 3}), 50, 0.3);
  int failures = 0;
  for (int nth = 0;; ++nth) {
    FailCall("clCreateBuffer", nth, CL_MEM_OBJECT_ALLOCATION_FAILURE);
    const auto posterior =
        DensePosterior::Create(TestContext(), problem.model(FactorKind::kCholesky));
    if (!CallHasFailed()) {
      EXPECT_TRUE(posterior.ok()) << posterior.status();
      break;
    }
    ++failures;
    EXPECT_EQ(posterior.status().code(), absl::StatusCode::kResourceExhausted);
  }
  EXPECT_GE(failures, 3);  // inputs, alpha, factor
}

// Without waiting: what was enqueued before the failure keeps what it uses.
TEST_F(DeviceFailureTest, EnqueuedPosterior) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 2, 3}), 50, 0.3);
  constexpr int64_t kQueries = 130;
  std::vector<float> queries(2 * kQueries, 0.5f);
  const DensePosteriorOptions options{.memory_cap_bytes = 1};
  for (const char* call :
       {"clCreateCommandQueue", "clCreateKernel", "clCreateBuffer", "clSetKernelArg",
        "clEnqueueNDRangeKernel", "clEnqueueFillBuffer", "clSetEventCallback"}) {
    // Its own: a workspace can come back to a context after its queue has finished.
    const auto opened = Value(OpenContext());
    Context& context = *opened;
    const cl::Buffer points(context.cl_context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                            queries.size() * sizeof(float), queries.data());
    const cl::Buffer mean(context.cl_context(), CL_MEM_WRITE_ONLY, kQueries * sizeof(float));
    DeviceOutputs outputs;
    outputs.mean.memory = mean();
    int failures = 0;
    for (int nth = 0; nth < 1000; ++nth) {
      SCOPED_TRACE(testing::Message() << call << " number " << nth);
      auto posterior =
          Value(DensePosterior::Create(opened, problem.model(FactorKind::kCholesky), options));
      context.ReleaseIdle();
      const cl::CommandQueue queue(context.cl_context(), context.cl_device());
      FailCall(call, nth, CL_OUT_OF_RESOURCES);
      const auto event = posterior->Enqueue({points(), kQueries}, outputs, {queue()});
      const bool failed = CallHasFailed();
      posterior.reset();
      queue.finish();
      if (event.ok()) clReleaseEvent(*event);
      if (!failed) {
        EXPECT_TRUE(event.ok()) << event.status();
        break;
      }
      ++failures;
      // Where it cannot be told when the commands end, the call waits for them.
      EXPECT_EQ(event.status().code(), std::string(call) == "clSetEventCallback"
                                           ? absl::StatusCode::kOk
                                           : absl::StatusCode::kResourceExhausted);
    }
    EXPECT_GE(failures, 1) << call;
  }
}

TEST_F(DeviceFailureTest, CovarianceMatrix) {
  constexpr int64_t kPoints = 20;
  const std::vector<double> points = RandomPoints(random_, kPoints, 2);
  FailEveryCall<double>(
      [&](OutputsOf<double>& out) {
        return CovarianceMatrix(*TestContext(), ArcsineParameters({1, 2, 3}),
                                {points.data(), kPoints, 2}, 0.1, Triangle::kFull,
                                {out[0].data(), kPoints, kPoints});
      },
      1, kPoints * kPoints, /*staged=*/false);
}

TEST_F(DeviceFailureTest, CovarianceGradient) {
  constexpr int64_t kPoints = 20;
  const std::vector<double> points = RandomPoints(random_, kPoints, 2);
  const std::vector<double> weights = RandomPoints(random_, kPoints, kPoints);
  FailEveryCall(
      [&](Outputs& out) {
        const auto gradient =
            CovarianceGradient(*TestContext(), ArcsineParameters({1, 2, 3}),
                               {points.data(), kPoints, 2}, {weights.data(), kPoints, kPoints});
        if (gradient.ok()) std::copy(gradient->begin(), gradient->end(), out[0].data());
        return gradient.status();
      },
      1, 4, /*staged=*/true);
}

TEST_F(DeviceFailureTest, CrossCovarianceAndItsGradient) {
  constexpr int64_t kPoints = 20, kOthers = 7;
  const std::vector<double> points = RandomPoints(random_, kPoints, 2);
  const std::vector<double> others = RandomPoints(random_, kOthers, 2);
  const std::vector<double> weights = RandomPoints(random_, kPoints, kOthers);
  FailEveryCall<double>(
      [&](OutputsOf<double>& out) {
        return CrossCovariance(*TestContext(), ArcsineParameters({1, 2, 3}),
                               {points.data(), kPoints, 2}, {others.data(), kOthers, 2},
                               {out[0].data(), kPoints, kOthers});
      },
      1, kPoints * kOthers, /*staged=*/false);
  FailEveryCall(
      [&](Outputs& out) {
        const auto gradient = CrossCovarianceGradient(
            *TestContext(), ArcsineParameters({1, 2, 3}), {points.data(), kPoints, 2},
            {others.data(), kOthers, 2}, {weights.data(), kPoints, kOthers});
        if (gradient.ok()) std::copy(gradient->begin(), gradient->end(), out[0].data());
        return gradient.status();
      },
      1, 4, /*staged=*/true);
}

// The matrices stay on the device; only what goes to the caller must be whole or not there.
TEST_F(DeviceFailureTest, ExactRegression) {
  constexpr int64_t kPoints = 70;  // two diagonal blocks
  const std::vector<double> points = RandomPoints(random_, kPoints, 2);
  const std::vector<double> targets = RandomPoints(random_, kPoints, 1);
  const auto regress = [&] {
    TestContext()->ReleaseIdle();
    return RegressOnDevice(*TestContext(), ArcsineParameters({1, 2, 3}),
                           {points.data(), kPoints, 2}, {targets.data(), kPoints, 1}, 0.1, {},
                           /*with_gradient=*/true);
  };
  const auto good = Value(regress());
  for (const char* call : {"clCreateKernel", "clCreateCommandQueue", "clCreateBuffer",
                           "clSetKernelArg", "clEnqueueNDRangeKernel", "clEnqueueFillBuffer",
                           "clEnqueueReadBuffer", "clEnqueueWriteBuffer"}) {
    int failures = 0;
    for (int nth = 0; nth < 1000; ++nth) {
      SCOPED_TRACE(testing::Message() << call << " number " << nth);
      FailCall(call, nth, CL_OUT_OF_RESOURCES);
      const auto result = regress();
      if (!CallHasFailed()) {
        EXPECT_TRUE(result.ok()) << result.status();
        break;
      }
      ++failures;
      EXPECT_EQ(result.status().code(), absl::StatusCode::kResourceExhausted);
      EXPECT_TRUE(absl::StrContains(absl::AsciiStrToLower(result.status().message()),
                                    absl::AsciiStrToLower(call)))
          << result.status();
      const auto again = Value(regress());
      EXPECT_EQ(again.alpha, good.alpha);
      EXPECT_EQ(again.gradient, good.gradient);
    }
    EXPECT_GE(failures, 1) << call << " never failed";
  }
}

}  // namespace
}  // namespace egosieve::kernels
