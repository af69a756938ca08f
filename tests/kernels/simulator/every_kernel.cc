// Runs every kernel once on the device that is there, scalar, in vectors and with tiles in local
// memory, on small inputs that end inside a vector, a panel and a tile, and compares with the
// reference. Run under a simulator that watches every access, it shows what the kernels touch.
#include <CL/opencl.hpp>
#include <algorithm>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/ops/device_linear_algebra.h"
#include "kernels/ops/exact_regression.h"
#include "kernels/reference/covariance.h"
#include "kernels/reference/dense_posterior.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

constexpr int64_t kPoints = 21;
constexpr int64_t kQueries = 37;
constexpr double kTolerance = 1e-4;  // accuracy is other tests' matter

template <typename A, typename B>
void ExpectNear(const std::vector<A>& actual, const std::vector<B>& expected,
                const std::string& what) {
  EXPECT_THAT(actual, testing::Pointwise(testing::Truly([](const auto& pair) {
                                           return std::abs(std::get<0>(pair) - std::get<1>(pair)) <=
                                                  kTolerance;
                                         }),
                                         expected))
      << what;
}

struct Inputs {
  explicit Inputs(std::mt19937_64& random)
      : points(RandomPoints(random, kPoints, 2)),
        alpha(RandomPoints(random, kPoints, 1)),
        factor(RandomPoints(random, kPoints, kPoints)) {
    for (const double value : RandomPoints(random, kQueries, 2)) {
      queries.push_back(static_cast<float>(value));
    }
    for (double& value : factor) value *= 0.1;
    for (int64_t i = 0; i < kPoints; ++i) factor[i * kPoints + i] = 3.0;
  }
  ConstMatrixView<double> x() const { return {points.data(), kPoints, 2}; }
  std::vector<double> points, alpha, factor;
  std::vector<float> queries;
};

// A composition that has every function's code in it.
CovarianceParameters EveryFunction() {
  std::string text = "isotropic(matern52)[1] * constant";
  for (const std::string& name : CovarianceFunction::Names()) text += " + " + name;
  CovarianceParameters parameters{.function = *CovarianceFunction::Parse(text), .dimension = 2};
  for (const ScaleGroup& group : parameters.function.description().scale_groups()) {
    for (int64_t d = 0; d < group.ScaleCount(2); ++d)
      parameters.scales.push_back(0.4 * group.initial);
  }
  return parameters;
}

void RunCovariance(Context& context, const CovarianceParameters& parameters, const Inputs& inputs) {
  std::vector<double> actual(kPoints * kPoints), expected(kPoints * kPoints);
  for (const Triangle triangle : {Triangle::kFull, Triangle::kLower}) {
    ASSERT_EQ(CovarianceMatrix(context, parameters, inputs.x(), 0.0, triangle,
                               {actual.data(), kPoints, kPoints}),
              absl::OkStatus());
    reference::CovarianceBlock(parameters, inputs.x(), inputs.x(), triangle == Triangle::kLower,
                               {expected.data(), kPoints, kPoints});
    ExpectNear(actual, expected, "covariance matrix");
  }
  const ConstMatrixView<double> weights(inputs.factor.data(), kPoints, kPoints);
  ExpectNear(Value(CovarianceGradient(context, parameters, inputs.x(), weights)),
             reference::CovarianceGradient(parameters, inputs.x(), inputs.x(), weights, true),
             "covariance gradient");
  Value(CrossCovarianceGradient(context, parameters, inputs.x(), inputs.x().rows_between(2, 7),
                                {inputs.factor.data(), kPoints, 5, kPoints}));
}

// From and to the device's memory.
void RunOnQueue(const Context& context, const DensePosterior& posterior, const Inputs& inputs,
                bool all, std::vector<std::vector<float>*> results) {
  constexpr size_t kBytes = kQueries * sizeof(float);
  std::vector<float> copy = inputs.queries;
  const cl::Buffer queries(context.cl_context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                           2 * kBytes, copy.data());
  const cl::Buffer mean(context.cl_context(), CL_MEM_READ_WRITE, kBytes);
  const cl::Buffer variance(context.cl_context(), CL_MEM_READ_WRITE, kBytes);
  const cl::Buffer probability(context.cl_context(), CL_MEM_READ_WRITE, kBytes);
  const cl::CommandQueue queue(context.cl_context(), context.cl_device());
  DeviceOutputs outputs;
  outputs.mean.memory = mean();
  if (all) outputs.variance.memory = variance();
  if (all) outputs.probability.memory = probability();
  cl::Event(Value(posterior.Enqueue({queries(), kQueries}, outputs, {queue()}))).wait();
  const cl::Buffer* buffers[] = {&mean, &variance, &probability};
  for (int i = 0; i < (all ? 3 : 1); ++i) {
    queue.enqueueReadBuffer(*buffers[i], CL_TRUE, 0, kBytes, results[i]->data());
  }
}

void RunPosterior(const std::shared_ptr<Context>& context, const CovarianceParameters& parameters,
                  const Inputs& inputs) {
  for (const FactorKind kind :
       {FactorKind::kNone, FactorKind::kCholesky, FactorKind::kInverseCholesky}) {
    const PosteriorModel model{.covariance = parameters,
                               .inputs = inputs.x(),
                               .alpha = inputs.alpha.data(),
                               .factor_kind = kind,
                               .factor = {inputs.factor.data(), kPoints, kPoints}};
    const auto posterior = Value(DensePosterior::Create(context, model));
    std::vector<float> mean(kQueries), variance(kQueries), probability(kQueries);
    std::vector<double> means(kQueries), variances(kQueries), probabilities(kQueries);
    const bool all = kind != FactorKind::kNone;
    const ConstMatrixView<float> queries(inputs.queries.data(), kQueries, 2);
    Value(posterior->Evaluate(queries, {mean.data(), all ? variance.data() : nullptr,
                                        all ? probability.data() : nullptr}));
    reference::DensePosterior(model).Evaluate(queries, means.data(),
                                              all ? variances.data() : nullptr,
                                              all ? probabilities.data() : nullptr);
    ExpectNear(mean, means, "mean");
    ExpectNear(variance, variances, "variance");
    ExpectNear(probability, probabilities, "probability");
    RunOnQueue(*context, *posterior, inputs, all, {&mean, &variance, &probability});
    ExpectNear(mean, means, "mean on a queue");
    ExpectNear(variance, variances, "variance on a queue");
    ExpectNear(probability, probabilities, "probability on a queue");
  }
}

// The factorisation and all that follows from it, against sums over what it gives.
void RunRegression(Context& context, const CovarianceParameters& parameters, const Inputs& inputs) {
  const double noise = 0.5;
  const ConstMatrixView<double> y(inputs.alpha.data(), kPoints, 1);
  const auto found = Value(RegressOnDevice(context, parameters, inputs.x(), y, noise, {}, true));
  ASSERT_EQ(found.bad_row, -1);
  std::vector<double> k(kPoints * kPoints), product(kPoints);
  reference::CovarianceBlock(parameters, inputs.x(), inputs.x(), false,
                             {k.data(), kPoints, kPoints});
  for (int64_t i = 0; i < kPoints; ++i) {
    product[i] = noise * found.alpha[i];
    for (int64_t j = 0; j < kPoints; ++j) product[i] += k[i * kPoints + j] * found.alpha[j];
  }
  ExpectNear(product, inputs.alpha, "regression");
}

// A B, where `a` is the lower triangle of the symmetric A; b: n x columns.
std::vector<double> TimesSymmetric(const std::vector<double>& a, const std::vector<double>& b,
                                   int64_t columns) {
  std::vector<double> product(kPoints * columns, 0.0);
  for (int64_t i = 0; i < kPoints; ++i) {
    for (int64_t j = 0; j < kPoints; ++j) {
      const double element = a[std::max(i, j) * kPoints + std::min(i, j)];
      for (int64_t c = 0; c < columns; ++c) {
        product[i * columns + c] += element * b[j * columns + c];
      }
    }
  }
  return product;
}

// Factorisation, solves and inverse across tiles; all points of the regression lie in one tile of
// the usual 64.
void RunLinearAlgebra(Context& context, const Inputs& inputs) {
  using opencl::DeviceLinearAlgebra;
  using opencl::DeviceMatrix;
  constexpr int64_t kColumns = 3;
  const auto workspace = Value(context.Borrow("simulating"));
  auto algebra = Value(DeviceLinearAlgebra::Create(context, *workspace, {8, 2, 4}));
  const cl::CommandQueue& queue = workspace->queue();
  const auto upload = [&](const std::vector<double>& values, int64_t columns) {
    DeviceMatrix matrix = opencl::NewDeviceMatrix(context, kPoints, columns);
    queue.enqueueWriteBuffer(matrix.buffer, CL_TRUE, 0, values.size() * sizeof(double),
                             values.data());
    return matrix;
  };
  const auto download = [&](const DeviceMatrix& matrix) {
    std::vector<double> values(matrix.rows * matrix.columns);
    queue.enqueueReadBuffer(matrix.buffer, CL_TRUE, 0, values.size() * sizeof(double),
                            values.data());
    return values;
  };
  // 3 on the diagonal and at most 0.1 beside it: positive definite.
  const std::vector<double>& a = inputs.factor;
  const cl::Buffer bad(context.cl_context(), CL_MEM_READ_WRITE, sizeof(cl_int));
  queue.enqueueFillBuffer(bad, cl_int{-1}, 0, sizeof(cl_int));
  const opencl::DeviceFactor factor =
      algebra.Factorize(upload(a, kPoints), upload(std::vector<double>(kPoints, 1e-13), 1), bad);
  const std::vector<double> b(inputs.factor.begin(), inputs.factor.begin() + kPoints * kColumns);
  DeviceMatrix x = upload(b, kColumns);
  algebra.SolveLower(factor, x);
  algebra.SolveLowerTransposed(factor, x);
  ExpectNear(TimesSymmetric(a, download(x), kColumns), b, "solution across tiles");
  DeviceMatrix inverse = opencl::NewDeviceMatrix(context, kPoints, kPoints);
  algebra.MultiplyInverse(algebra.InvertLower(factor), inverse);
  std::vector<double> whole = download(inverse), identity(kPoints * kPoints, 0.0);
  for (int64_t i = 0; i < kPoints; ++i) {
    identity[i * kPoints + i] = 1.0;
    for (int64_t j = i + 1; j < kPoints; ++j) whole[i * kPoints + j] = whole[j * kPoints + i];
  }
  ExpectNear(TimesSymmetric(a, whole, kPoints), identity, "inverse across tiles");
}

TEST(EveryKernel, AgreesWithTheReference) {
  std::mt19937_64 random = TestRandom();
  const Inputs inputs(random);
  std::vector<KernelTuning> shapes;
  for (const int lanes : {1, 4, 16}) {
    shapes.push_back(DefaultTuning(lanes));
    if (lanes == 1) shapes.back().work_group = 4;
    shapes.back().panels_per_group = 2;
    shapes.back().panel = 4;
    shapes.back().depth = 12;
    shapes.back().width = 2;
  }
  // Blocks of 16 rows, tiles of 6 queries with the factor and of 16 without.
  shapes.push_back(DefaultGpuTuning());
  shapes.back().panel = 4;
  shapes.back().panels_per_group = 4;
  shapes.back().depth = 8;
  shapes.back().work_group = 8;
  shapes.back().width = 3;
  shapes.back().mean_width = 2;
  for (const KernelTuning& shape : shapes) {
    ContextOptions options{.tuning = shape};
    options.tuning->groups_per_unit = 2;
    // The points of EveryFunction need smaller blocks.
    if (shape.local_tiles) options.local_memory_bytes = 1536;
    const auto context = Value(OpenContext(options));
    std::printf("%s, %d lanes%s\n", context->info().name.c_str(), shape.float_lanes,
                shape.local_tiles ? ", tiles in local memory" : "");
    for (const CovarianceParameters& parameters :
         {CovarianceParameters{CovarianceFunction::kArcsine, {0.3, 0.3, 0.3}, 1.0},
          CovarianceParameters{CovarianceFunction::kArcsine, {1.0, 5.0, 2.0}, 1.0},
          CovarianceParameters{CovarianceFunction::kSquaredExponential, {0.5, 1.0}, 1.0},
          EveryFunction()}) {
      RunCovariance(*context, parameters, inputs);
      RunPosterior(context, parameters, inputs);
    }
    RunRegression(*context, EveryFunction(), inputs);
    if (shape == shapes.front()) RunLinearAlgebra(*context, inputs);  // the same for all
  }
}

}  // namespace
}  // namespace egosieve::kernels
