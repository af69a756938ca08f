// The C++ interface: that it is the C interface, owned. What is computed is tested there.
#include "egosieve/gaussian_process.hpp"

#include <CL/cl.h>

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "egosieve/eigen.hpp"
#include "gtest/gtest.h"

namespace egosieve {
namespace {

constexpr int kPoints = 30, kQueries = 20, kDimension = 2;

struct Data {
  Eigen::MatrixXd x{kPoints, kDimension};  // column-major
  Eigen::VectorXd y{kPoints};
  Eigen::Matrix<float, kQueries, kDimension, Eigen::RowMajor> queries;

  Data() {
    for (int i = 0; i < kPoints; ++i) {
      x.row(i) << std::cos(1.7 * i), std::sin(0.9 * i);
      y[i] = std::tanh(3.0 * x(i, 0) * x(i, 1));
    }
    for (int i = 0; i < kQueries; ++i) {
      queries.row(i) << static_cast<float>(std::sin(0.4 * i)), static_cast<float>(0.05 * i);
    }
  }
};

GaussianProcess ConditionedModel(const Data& data) {
  GaussianProcess gp = GaussianProcess::Create({.dimension = kDimension}).value();
  gp.Condition(View(data.x), View(data.y)).ThrowIfError();
  return gp;
}

TEST(GaussianProcess, SpansAndEigenGiveTheSameBits) {
  const Data data;
  const GaussianProcess by_eigen = ConditionedModel(data);
  GaussianProcess by_span = GaussianProcess::Create({.dimension = kDimension}).value();
  const std::vector<double> columns(data.x.data(), data.x.data() + data.x.size());
  const std::vector<double> targets(data.y.data(), data.y.data() + data.y.size());
  by_span.Condition(ConstArray(columns.data(), kPoints, kDimension, 1, kPoints), targets)
      .ThrowIfError();

  Eigen::VectorXf mean(kQueries);
  Eigen::MatrixXd both(3, kQueries);  // results go into rows of a larger matrix
  ASSERT_TRUE(by_eigen.Predict(View(data.queries), {MutableView(mean)}).ok());
  const std::vector<float> rows(data.queries.data(), data.queries.data() + data.queries.size());
  ASSERT_TRUE(
      by_span.Predict({rows, kDimension}, {MutableView(both.row(2)), MutableView(both.row(0))})
          .ok());
  for (int i = 0; i < kQueries; ++i) {
    EXPECT_EQ(static_cast<double>(mean[i]), both(2, i));
    EXPECT_GT(both(0, i), 0.0);
  }
}

TEST(GaussianProcess, RefusesAVectorWithoutWholeRows) {
  const Data data;
  GaussianProcess gp = ConditionedModel(data);
  const std::vector<double> five(5);
  for (const int columns : {2, 0, -1}) {
    const Status refused = gp.Condition({five, columns}, std::vector<double>(2));
    EXPECT_EQ(refused.code(), Code::kInvalidArgument);
    EXPECT_NE(refused.message().find("no multiple of the columns"), std::string::npos);
  }
  EXPECT_EQ(gp.Describe().value().size, kPoints);
}

TEST(GaussianProcess, ClassifiesAndGivesItsKernelMatrix) {
  const Data data;
  GaussianProcess gp = ConditionedModel(data);
  Eigen::MatrixXd k(kPoints, kPoints), half(kPoints, 5);
  std::vector<double> slopes(kPoints * 5 * 4);
  ASSERT_TRUE(gp.Covariances(View(data.x), {}, MutableView(k)).ok());
  ASSERT_TRUE(gp.Covariances(View(data.x), View(data.x.topRows(5)), MutableView(half),
                             Array(slopes.data(), kPoints * 5, 4))
                  .ok());
  EXPECT_LT((k.leftCols(5) - half).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NEAR(slopes[4 * 7 + 3], 2.0 * half(1, 2), 1e-14);
  const Eigen::VectorXd labels =
      (data.y.array() < 0.0).select(-Eigen::VectorXd::Ones(kPoints), 1.0);
  const OptimizeOptions options;
  const Result<OptimizeResult> found = gp.Classify(View(data.x), View(labels), {}, &options);
  ASSERT_TRUE(found.ok());
  EXPECT_GT(found.value().log_likelihood, found.value().log_likelihood_at_start);
  Eigen::VectorXf probability(kPoints);
  const Eigen::MatrixXf queries = data.x.cast<float>();
  ASSERT_TRUE(gp.Predict(View(queries), {{}, {}, MutableView(probability)}).ok());
  for (int i = 0; i < kPoints; ++i) EXPECT_EQ(probability[i] > 0.5f, labels[i] > 0.0) << i;
}

TEST(GaussianProcess, MovesOwnTheHandleOnce) {
  const Data data;
  GaussianProcess first = ConditionedModel(data);
  GaussianProcess second = std::move(first);
  EXPECT_EQ(first.handle(), nullptr);
  EXPECT_EQ(first.Calibrate().code(), Code::kInvalidHandle);
  egosieve_gp* handle = second.handle();
  first = std::move(second);
  EXPECT_EQ(first.handle(), handle);
  EXPECT_EQ(first.Describe()->size, kPoints);
  { const GaussianProcess last = std::move(first); }
  double value = 0.0;
  EXPECT_EQ(egosieve_gp_log_marginal_likelihood(handle, &value), EGOSIEVE_INVALID_HANDLE);
}

TEST(GaussianProcess, ErrorsAreReturnedOrThrown) {
  const Data data;
  GaussianProcess gp = ConditionedModel(data);
  const std::vector<double> one = {1.0};
  const Status status = gp.Condition(View(data.x), one);
  EXPECT_EQ(status.code(), Code::kInvalidArgument);
  EXPECT_NE(status.message().find("y: 1 values; x has 30 rows"), std::string::npos)
      << status.message();
  EXPECT_THROW(status.ThrowIfError(), Error);
  const Result<GaussianProcess> none = GaussianProcess::Load("/nowhere/model.npz");
  EXPECT_FALSE(none.ok());
  try {
    none.value();
    FAIL() << "value() of no value returned";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), Code::kNotFound);
  }
}

TEST(GaussianProcess, BytesAndPosteriorKeepTheModel) {
  const Data data;
  GaussianProcess gp = ConditionedModel(data);
  ASSERT_TRUE(gp.SetAnnotation("of the caller").ok());
  ASSERT_TRUE(gp.Remove({3, 1, 4}).ok());
  const OptimizeResult optimised = gp.Optimize().value();
  EXPECT_GT(optimised.log_likelihood, optimised.log_likelihood_at_start);
  const std::string bytes = gp.Serialize().value();
  const GaussianProcess again = GaussianProcess::Deserialize(bytes).value();
  EXPECT_EQ(again.Annotation().value(), "of the caller");
  const GaussianProcessInfo info = again.Describe().value();
  EXPECT_EQ(info.size, kPoints - 3);
  EXPECT_EQ(info.scales, gp.Describe()->scales);
  const Posterior posterior = gp.MakePosterior().value();
  ASSERT_TRUE(gp.Remove({0}).ok());
  std::vector<float> expected(kQueries), actual(kQueries);
  ASSERT_TRUE(posterior.Predict(View(data.queries), {expected}).ok());
  ASSERT_TRUE(again.Predict(View(data.queries), {actual}).ok());
  EXPECT_EQ(expected, actual);
  Eigen::MatrixXf x(info.size, kDimension);
  ASSERT_TRUE(again.Points(MutableView(x), {}).ok());
  EXPECT_EQ(x(0, 1), static_cast<float>(data.x(0, 1)));
  EXPECT_EQ(x(1, 0), static_cast<float>(data.x(2, 0)));
}

void ExpectTheHostsKernelMatrix(const GaussianProcess& gp, cl_context context,
                                cl_command_queue queue) {
  std::vector<double> matrix(4), on_host(4), inputs = {0.1, 0.2, 0.3, -0.4, 0.5, 0.6};
  inputs.resize(2 * kDimension);
  cl_int error;
  cl_mem points = clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, inputs.size() * sizeof(double),
                                 inputs.data(), &error);
  cl_mem k = clCreateBuffer(context, CL_MEM_READ_WRITE, 4 * sizeof(double), nullptr, &error);
  cl_event done = static_cast<cl_event>(
      gp.EnqueueCovariances({points, 0, 2, 0}, {points, 0, 2, 0}, {k, 0, 2, 0}, queue).value());
  EXPECT_EQ(clEnqueueReadBuffer(queue, k, CL_TRUE, 0, 4 * sizeof(double), matrix.data(), 1, &done,
                                nullptr),
            CL_SUCCESS);
  ASSERT_TRUE(gp.Covariances({inputs, kDimension}, {}, {on_host.data(), 2, 2}).ok());
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(matrix[i], on_host[i], 1e-14);
  clReleaseEvent(done);
  clReleaseMemObject(k);
  clReleaseMemObject(points);
}

TEST(GaussianProcess, PredictsOnTheCallersQueue) {
  const Data data;
  const Posterior elsewhere = ConditionedModel(data).MakePosterior().value();
  if (!elsewhere.OpenClDevice().ok()) GTEST_SKIP() << "the reference device has no OpenCL";
  cl_device_id device = static_cast<cl_device_id>(elsewhere.OpenClDevice().value());
  cl_int error = CL_SUCCESS;
  cl_context context = clCreateContext(nullptr, 1, &device, nullptr, nullptr, &error);
  ASSERT_EQ(error, CL_SUCCESS);
  cl_command_queue queue = clCreateCommandQueue(context, device, 0, &error);
  ASSERT_EQ(error, CL_SUCCESS);
  {
    GaussianProcessOptions options{.dimension = kDimension};
    // The device prepares its queries to the bit as the host does.
    options.covariance = Covariance::kNamed;
    options.covariance_text = "matern52";
    options.opencl_context = context;
    options.opencl_device = device;
    GaussianProcess gp = GaussianProcess::Create(options).value();
    gp.Condition(View(data.x), View(data.y)).ThrowIfError();
    const Posterior frozen = gp.MakePosterior().value();
    EXPECT_EQ(frozen.OpenClContext().value(), context);

    std::vector<float> rows(data.queries.data(), data.queries.data() + data.queries.size());
    std::vector<float> mean(kQueries), expected(kQueries);
    cl_mem places = clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, rows.size() * sizeof(float),
                                   rows.data(), &error);
    cl_mem means =
        clCreateBuffer(context, CL_MEM_READ_WRITE, mean.size() * sizeof(float), nullptr, &error);
    DeviceCall call;
    call->queue = queue;
    call->queries = places;
    call->query_count = kQueries;
    call->mean.memory = means;
    cl_event done = static_cast<cl_event>(frozen.Enqueue(call).value());
    EXPECT_EQ(clEnqueueReadBuffer(queue, means, CL_TRUE, 0, mean.size() * sizeof(float),
                                  mean.data(), 1, &done, nullptr),
              CL_SUCCESS);
    ASSERT_TRUE(frozen.Predict({rows, kDimension}, {expected}).ok());
    EXPECT_EQ(mean, expected);
    clReleaseEvent(done);
    ExpectTheHostsKernelMatrix(gp, context, queue);
    clReleaseMemObject(means);
    clReleaseMemObject(places);
  }
  clReleaseCommandQueue(queue);
  clReleaseContext(context);
}

TEST(GaussianProcess, SharesAPosteriorAmongDevices) {
  const Data data;
  const GaussianProcess gp = ConditionedModel(data);
  const Posterior single = gp.MakePosterior().value();
  const Posterior shared = gp.MakePosterior({"", ""}).value();
  constexpr int kMany = 3000;  // both devices compute
  std::vector<double> places(kMany * kDimension);
  for (size_t i = 0; i < places.size(); ++i) places[i] = std::sin(0.37 * static_cast<double>(i));
  std::vector<float> expected(kMany), found(kMany);
  ASSERT_TRUE(single.Predict({places, kDimension}, {expected}).ok());
  ASSERT_TRUE(shared.Predict({places, kDimension}, {found}).ok());
  EXPECT_EQ(found, expected);
  EXPECT_EQ(shared.OpenClContext().status().code(), Code::kFailedPrecondition);
  EXPECT_EQ(gp.MakePosterior({"", "nowhere"}).status().code(), Code::kNotFound);
  EXPECT_EQ(gp.MakePosterior(std::vector<std::string>()).status().code(), Code::kInvalidArgument);
}

TEST(GaussianProcess, JointPredictionsAreTheCInterfaces) {
  const Data data;
  const GaussianProcessOptions options{.covariance = Covariance::kNamed,
                                       .covariance_text = "matern52",
                                       .mean = Mean::kConstant,
                                       .dimension = kDimension};
  GaussianProcess gp = GaussianProcess::Create(options).value();
  const Eigen::VectorXd noise = Eigen::VectorXd::LinSpaced(kPoints, 0.0, 0.1);
  Eigen::MatrixXd both(kPoints, 2);
  both << data.y, 3.0 * data.y;
  gp.Condition(View(data.x), View(both), View(noise)).ThrowIfError();
  const GaussianProcessInfo info = gp.Describe().value();
  EXPECT_EQ(info.covariance_text, "matern52");
  EXPECT_EQ(info.mean, Mean::kConstant);
  EXPECT_EQ(info.outputs, 2);
  Eigen::MatrixXd mean(kQueries, 2), covariance(kQueries, kQueries), samples(2 * kQueries, 5);
  gp.PredictJoint(View(data.queries), MutableView(mean), MutableView(covariance)).ThrowIfError();
  // Three times the targets, three times the mean.
  EXPECT_LE((mean.col(1) - 3.0 * mean.col(0)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(covariance, Eigen::MatrixXd(covariance.transpose()));
  EXPECT_GE(gp.Sample(View(data.queries), 1, MutableView(samples)).value(), 0.0);
  gp.SamplePaths(View(data.queries), 1, MutableView(samples)).ThrowIfError();
  const Eigen::MatrixXd paths = samples;
  samples.setZero();
  gp.SamplePaths(View(data.queries), 1, MutableView(samples), false, 1024).ThrowIfError();
  EXPECT_EQ(samples, paths);
  Eigen::MatrixXd wide(kQueries, 2), variance(kQueries, 1);
  Prediction prediction{MutableView(wide), MutableView(variance)};
  prediction.precision = Precision::kFloat64;
  const PredictionCounts counts = gp.Predict(View(data.queries), prediction).value();
  EXPECT_EQ(counts.in_float64, kQueries);
  EXPECT_EQ(counts.clamped_variances, 0);
  const Float32Error error = gp.MakePosterior().value().ErrorOfFloat32().value();
  EXPECT_GT(error.mean, 0.0);
  EXPECT_GT(error.variance, 0.0);
  EXPECT_GT(error.deviation, 0.0);
  EXPECT_EQ(wide, mean);
  EXPECT_NEAR(variance(3, 0), covariance(3, 3), 1e-12);
  Eigen::MatrixXd gradient(2 * kQueries, kDimension), of_variance(kQueries, kDimension);
  gp.Gradients(View(data.queries), MutableView(gradient), MutableView(of_variance)).ThrowIfError();
  EXPECT_NEAR(gradient(1, 0), 3.0 * gradient(0, 0), 1e-9);
  Eigen::MatrixXd left(kPoints, 2), coefficients(1, 2);
  gp.LeaveOneOut({MutableView(left)}).ThrowIfError();
  gp.MeanCoefficients(MutableView(coefficients)).ThrowIfError();
  EXPECT_NEAR(coefficients(0, 1), 3.0 * coefficients(0, 0), 1e-9);
  const std::vector<double> theta = {std::log(info.scales[0]), std::log(info.scales[1]),
                                     std::log(info.signal_stddev), std::log(info.noise_stddev)};
  const Likelihood likelihood = gp.LikelihoodAt(theta, true).value();
  EXPECT_NEAR(likelihood.value, gp.LogMarginalLikelihood().value(),
              1e-9 * std::abs(likelihood.value));
  EXPECT_EQ(likelihood.gradient.size(), 4u);
  Eigen::VectorXd back(kPoints);
  gp.NoiseVariances(MutableView(back)).ThrowIfError();
  EXPECT_EQ(back, noise);
}

TEST(GaussianProcess, SparseModelsAreTheCInterfaces) {
  const Data data;
  const GaussianProcessOptions options{
      .dimension = kDimension, .approximation = Approximation::kFitc, .inducing_points = 12};
  GaussianProcess gp = GaussianProcess::Create(options).value();
  gp.Condition(View(data.x), View(data.y)).ThrowIfError();
  const GaussianProcessInfo info = gp.Describe().value();
  EXPECT_EQ(info.approximation, Approximation::kFitc);
  EXPECT_EQ(info.inducing_points, 12);
  EXPECT_EQ(info.inducing_count, 12);
  Eigen::MatrixXd mean(kQueries, 1), gradient(kQueries, kDimension);
  gp.PredictJoint(View(data.queries), MutableView(mean), {}).ThrowIfError();
  gp.Gradients(View(data.queries), MutableView(gradient)).ThrowIfError();
  EXPECT_TRUE(mean.allFinite() && gradient.allFinite());
}

TEST(GaussianProcess, IterativeModelsAreTheCInterfaces) {
  const Data data;
  const GaussianProcessOptions options{.dimension = kDimension,
                                       .approximation = Approximation::kIterative,
                                       .inducing_points = 12,
                                       .tolerance = 1e-6};
  GaussianProcess gp = GaussianProcess::Create(options).value();
  gp.Condition(View(data.x), View(data.y)).ThrowIfError();
  EXPECT_EQ(gp.Describe().value().iterations, -1);
  Eigen::MatrixXd gradient(kQueries, kDimension);
  gp.Gradients(View(data.queries), MutableView(gradient)).ThrowIfError();
  const GaussianProcessInfo info = gp.Describe().value();
  EXPECT_EQ(info.approximation, Approximation::kIterative);
  EXPECT_EQ(info.tolerance, 1e-6);
  EXPECT_GT(info.iterations, 0);
  EXPECT_LE(info.residual, 1e-6);
}

}  // namespace
}  // namespace egosieve
