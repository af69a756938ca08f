// A process forked from one that has used OpenCL is told so, where its first command would wait for
// ever.
#include <unistd.h>

#include <string>

#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/device.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

absl::Status Compute(Context& context) {
  const double x[3] = {0.1, 0.2, 0.5};
  double k[9];
  return CovarianceMatrix(context, {CovarianceFunction::kSquaredExponential, {1.0}, 1.0}, {x, 3, 1},
                          0.0, Triangle::kFull, {k, 3, 3});
}

// Which of the things that must be refused are not; called in the child.
int NotRefused(const std::shared_ptr<Context>& context) {
  const auto refused = [](const absl::Status& status) {
    return absl::IsFailedPrecondition(status) &&
           std::string(status.message()).find("spawn") != std::string::npos;
  };
  if (!refused(Compute(*context))) return 1;
  if (!refused(OpenContext().status())) return 2;
  if (!refused(ListDevices().status())) return 3;
  const PosteriorModel prior{.covariance = {CovarianceFunction::kSquaredExponential, {1.0}, 1.0}};
  if (!refused(DensePosterior::Create(context, prior).status())) return 4;
  const auto reference = OpenContext({.device = "reference"});
  return reference.ok() && Compute(**reference).ok() ? 0 : 5;
}

TEST(Fork, AChildOfAProcessThatUsedOpenClIsRefused) {
  const auto context = Value(OpenContext());
  if (context->is_reference()) GTEST_SKIP() << "the reference survives forks";
  ASSERT_TRUE(Compute(*context).ok());
  EXPECT_EXIT(
      {
        alarm(60);
        _exit(NotRefused(context));
      },
      testing::ExitedWithCode(0), "");
  EXPECT_TRUE(Compute(*context).ok());
}

}  // namespace
}  // namespace egosieve::kernels
