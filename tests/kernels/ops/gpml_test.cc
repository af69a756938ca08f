// The numbers of GPML 3.6 on its 20-point regression demo: covNNone with (log ell, log sf) = (0,
// 0), zero mean, Gaussian likelihood with log sn = log 0.1. covNNone's sf2 asin(x~' P x~' / ...)
// with P = I / ell^2 is the arcsine covariance with w^2 = 1 / (2 ell^2) for the bias and for x.
#include <Eigen/Cholesky>
#include <cmath>

#include "gtest/gtest.h"
#include "kernels/ops/covariance_gradient.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/reference/dense_posterior.h"
#include "tests/kernels/gpml_demo.h"
#include "tests/kernels/test_data.h"

namespace egosieve::kernels {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class GpmlTest : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<double> y;
    for (const auto& [x, value] : kGpmlDemo) {
      x_.push_back(x);
      y.push_back(value);
    }
    n_ = static_cast<int64_t>(x_.size());
    y_ = Eigen::Map<Eigen::VectorXd>(y.data(), n_);
    parameters_ = ArcsineParameters({std::sqrt(0.5), std::sqrt(0.5)});
    RowMajor k(n_, n_);
    const absl::Status status =
        CovarianceMatrix<double>(*TestContext(), parameters_, {x_.data(), n_, 1}, kNoiseVariance,
                                 Triangle::kFull, MatrixView<double>(k.data(), n_, n_));
    ASSERT_TRUE(status.ok()) << status;
    lower_ = k.llt().matrixL();
    alpha_ = k.llt().solve(y_);
    inverse_ = k.llt().solve(RowMajor::Identity(n_, n_));
  }

  static constexpr double kNoiseVariance = 0.01;
  int64_t n_ = 0;
  std::vector<double> x_;
  Eigen::VectorXd y_, alpha_;
  CovarianceParameters parameters_;
  RowMajor lower_, inverse_;
};

// GPML's values have 16 digits; 1e-10 relative is far above what conditioning of about 2e3 leaves
// of float64.
void ExpectAgrees(double actual, double expected) {
  EXPECT_NEAR(actual, expected, 1e-10 * std::abs(expected));
}

TEST_F(GpmlTest, MarginalLikelihood) {
  const double value =
      0.5 * y_.dot(alpha_) + lower_.diagonal().array().log().sum() + 0.5 * n_ * std::log(2 * M_PI);
  ExpectAgrees(value, 224.6467058483673);
}

TEST_F(GpmlTest, GradientOfTheMarginalLikelihood) {
  const RowMajor w = alpha_ * alpha_.transpose() - inverse_;
  const auto gradient =
      CovarianceGradient(*TestContext(), parameters_, {x_.data(), n_, 1}, {w.data(), n_, n_});
  ASSERT_TRUE(gradient.ok()) << gradient.status();
  // Both weights are 1 / (sqrt(2) ell): d/dlog ell = -(d/dlog w_0 + d/dlog w_1). The negative
  // likelihood's gradient is -g/2.
  ExpectAgrees(0.5 * ((*gradient)[0] + (*gradient)[1]), 121.0143804398566);
  ExpectAgrees(-0.5 * (*gradient)[2], -88.35929876048047);
}

TEST_F(GpmlTest, LeaveOneOut) {
  double value = 0.0;
  for (int64_t i = 0; i < n_; ++i) {
    const double variance = 1.0 / inverse_(i, i);
    const double residual = alpha_[i] * variance;
    value += 0.5 * std::log(2 * M_PI * variance) + residual * residual / (2 * variance);
  }
  ExpectAgrees(value, 233.8821292629794);
}

TEST_F(GpmlTest, PosteriorOfTheReference) {
  PosteriorModel model;
  model.covariance = parameters_;
  model.inputs = ConstMatrixView<double>(x_.data(), n_, 1);
  model.alpha = alpha_.data();
  model.factor_kind = FactorKind::kCholesky;
  model.factor = ConstMatrixView<double>(lower_.data(), n_, n_);
  const double queries[] = {0.0, 1.0};
  double mean[2], variance[2];
  reference::DensePosterior(model).Evaluate<double, double>({queries, 2, 1}, mean, variance,
                                                            nullptr);
  ExpectAgrees(mean[0], 1.366929392622168);
  ExpectAgrees(mean[1], 2.486821640898967);
  // The variance of f is the difference of numbers a hundred times as large.
  EXPECT_NEAR(variance[0] + kNoiseVariance, 0.01163764014804, 1e-12);
  EXPECT_NEAR(variance[1] + kNoiseVariance, 0.01511797539900, 1e-12);
}

}  // namespace
}  // namespace egosieve::kernels
