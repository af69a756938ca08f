// Points prepared on the device are those that the host prepares.
#include "kernels/ops/device_preparation.h"

#include <CL/opencl.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/kernels/covariance/expressions.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels::opencl {
namespace {

constexpr int64_t kCount = 21, kPadded = 24;

class DevicePreparationTest : public testing::TestWithParam<std::string> {
 protected:
  // As columns, of D inputs around 3.
  void ExpectTheHosts(int64_t dimension) const {
    std::mt19937_64 random = TestRandom();
    const CovarianceParameters parameters = ParametersOf(GetParam(), dimension);
    const PointPreparation preparation(parameters, std::vector<double>(dimension, 3.0));
    std::vector<float> points;
    for (const double value : RandomPoints(random, kCount, dimension)) {
      points.push_back(static_cast<float>(value + 3.0));
    }
    Context& context = *TestContext();
    auto workspace = Value(context.Borrow("testing"));
    const cl::CommandQueue& queue = workspace->queue();
    const DevicePreparation device(context, parameters, preparation);
    auto kernel = Value(device.Kernel<float, float>(context, *workspace));
    const int64_t width = preparation.width();
    const cl::Buffer input(context.cl_context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                           points.size() * sizeof(float), points.data());
    const cl::Buffer output(context.cl_context(), CL_MEM_READ_WRITE,
                            width * kPadded * sizeof(float));
    device.Enqueue(kernel, queue, {input, 0, dimension, kCount}, {output, kPadded, 1, kPadded}, {});
    std::vector<float> actual(width * kPadded);
    queue.enqueueReadBuffer(output, CL_TRUE, 0, actual.size() * sizeof(float), actual.data());
    std::vector<double> expected(width);
    for (int64_t i = 0; i < kPadded; ++i) {
      if (i < kCount) preparation.Prepare(&points[i * dimension], expected.data(), 1);
      for (int64_t c = 0; c < width; ++c) {
        const double value = i < kCount ? expected[c] : 0.0;
        // One rounding to float32, and what the sine and contracted sums of float64 leave.
        ASSERT_NEAR(actual[c * kPadded + i], value,
                    std::ldexp(std::abs(value), -24) * (1.0 + 1e-6) + 1e-14)
            << "value " << c << " of point " << i;
      }
    }
  }
};

TEST_P(DevicePreparationTest, IsTheHosts) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference prepares on the host";
  for (const int64_t dimension : {1, 6, 32, 100}) ExpectTheHosts(dimension);
}

INSTANTIATE_TEST_SUITE_P(Functions, DevicePreparationTest, testing::ValuesIn(Expressions()),
                         [](const auto& info) {
                           std::string name = std::to_string(info.index) + "_";
                           for (const char c : info.param) {
                             if (std::isalnum(static_cast<unsigned char>(c))) name.push_back(c);
                           }
                           return name;
                         });

}  // namespace
}  // namespace egosieve::kernels::opencl
