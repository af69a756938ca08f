#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "gp/calibration/leave_one_out.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/incremental_cholesky.h"
#include "gp/model/exact_model.h"
#include "tests/gp/learning_problems.h"
#include "tests/gp/linalg/random_matrices.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;
using testing::HasSubstr;

ExactModel Fit(const Hyperparameters& theta, const RowMatrix& x,
               const std::vector<double>& labels) {
  auto model = Value(ExactModel::Create(TestContext(), theta));
  EXPECT_TRUE(model.Add(ViewOf(x), labels, 0).ok());
  return model;
}

TEST(LeaveOneOut, EqualsExplicitRefits) {
  auto generator = TestGenerator();
  for (const int64_t n : {1, 2, 9, 65}) {
    const LabelledPoints points = NoisyBlobs(n, 4, generator);
    const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 4);
    const ExactModel model = Fit(theta, points.inputs, points.labels);
    const auto left_out = Value(model.PredictLeaveOneOut());
    for (int64_t i = 0; i < n; ++i) {
      RowMatrix rest(n - 1, 4);
      rest << points.inputs.topRows(i), points.inputs.bottomRows(n - 1 - i);
      std::vector<double> labels = points.labels;
      labels.erase(labels.begin() + i);
      const ExactModel without = Fit(theta, rest, labels);
      const RowMatrix query = points.inputs.row(i);
      const auto expected = Value(Predict(without, ViewOf(query), PredictWhat::kMeanAndVariance));
      EXPECT_NEAR(left_out.mean[i], expected.mean[0], 1e-10);
      EXPECT_NEAR(left_out.target_variance[i], expected.variance[0] + theta.noise_variance(),
                  1e-10);
      EXPECT_NEAR(left_out.LatentVariance(theta.noise_variance())[i], expected.variance[0], 1e-10);
    }
  }
}

TEST(LeaveOneOut, ASampleIsPartOfTheWhole) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(400, 6, generator);
  const ExactModel model =
      Fit(DefaultHyperparameters(CovarianceFunction::kArcsine, 6), points.inputs, points.labels);
  const auto whole = Value(model.PredictLeaveOneOut());
  const std::vector<int64_t> rows = RandomRows(400, 150, generator);
  const auto sample = Value(model.PredictLeaveOneOut(rows));
  EXPECT_EQ(sample.rows, rows);
  for (size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(sample.mean[i], whole.mean[rows[i]], 1e-11);
    EXPECT_NEAR(sample.target_variance[i], whole.target_variance[rows[i]], 1e-11);
  }
  EXPECT_THAT(model.PredictLeaveOneOut({3, 3}), IsInvalid());
  EXPECT_THAT(model.PredictLeaveOneOut({400}), IsInvalid());
}

TEST(StratifiedSample, KeepsTheRareClass) {
  std::vector<double> targets(1000, -1.0);
  for (int i = 0; i < 60; ++i) targets[i * 16] = 1.0;
  const auto count_high = [&](const std::vector<int64_t>& rows) {
    return std::count_if(rows.begin(), rows.end(), [&](int64_t i) { return targets[i] >= 0.0; });
  };
  const std::vector<int64_t> sample = StratifiedSample(targets, 200, 0.25, 1);
  EXPECT_EQ(sample.size(), 200u);
  EXPECT_TRUE(std::is_sorted(sample.begin(), sample.end()));
  EXPECT_EQ(std::adjacent_find(sample.begin(), sample.end()), sample.end());
  EXPECT_EQ(count_high(sample), 50);
  EXPECT_EQ(count_high(StratifiedSample(targets, 200, 0.0, 1)), 12);
  EXPECT_EQ(count_high(StratifiedSample(targets, 400, 0.5, 1)), 60);  // all there are
  EXPECT_EQ(sample, StratifiedSample(targets, 200, 0.25, 1));
  EXPECT_NE(sample, StratifiedSample(targets, 200, 0.25, 2));
  EXPECT_EQ(StratifiedSample(targets, 5000, 0.25, 1).size(), 1000u);
  EXPECT_TRUE(StratifiedSample(targets, 0, 0.25, 1).empty());
  EXPECT_TRUE(StratifiedSample({}, 10, 0.25, 1).empty());
  for (double& target : targets) target = -1.0;
  EXPECT_EQ(StratifiedSample(targets, 200, 0.25, 1).size(), 200u);
}

struct Sample {
  std::vector<double> means, variances, labels;
};

// Labels drawn from the model itself with a = 2.5, b = -0.4.
Sample DrawSample(int n, uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const SquashParameters truth{2.5, -0.4};
  Sample sample;
  for (int i = 0; i < n; ++i) {
    sample.means.push_back(2.0 * uniform(generator) - 1.0);
    sample.variances.push_back(0.3 * uniform(generator));
    const double p = truth.Probability(sample.means[i], sample.variances[i]);
    sample.labels.push_back(uniform(generator) < p ? 1.0 : 0.0);
  }
  return sample;
}

TEST(Squash, ProbabilityFollowsTheFormula) {
  EXPECT_EQ((SquashParameters{1.0, 0.0}.Probability(0.0, 3.0)), 0.5);
  // Phi(1) = 0.8413447460685429 with a = 2, b = 0.2, mean 0.6, variance (1.4^2 - 1) / 4.
  EXPECT_NEAR((SquashParameters{2.0, 0.2}.Probability(0.6, 0.24)), 0.8413447460685429, 1e-15);
}

// (LS2) at these parameters.
double LogLikelihood(const SquashParameters& at, const std::vector<double>& means,
                     const std::vector<double>& variances, const std::vector<double>& labels) {
  double sum = 0.0;
  for (size_t i = 0; i < means.size(); ++i) {
    const double z = (at.a * means[i] + at.b) / std::sqrt(1.0 + at.a * at.a * variances[i]);
    sum += labels[i] * LogNormalDistribution(z).value;
    sum += (1.0 - labels[i]) * LogNormalDistribution(-z).value;
  }
  return sum;
}

TEST(Squash, LikelihoodHasNoUnderflow) {
  // log Phi(-40) = -804.608442 (Mills' ratio); a plain logarithm of Phi is -infinity.
  EXPECT_NEAR(LogLikelihood({1.0, 0.0}, {-40.0}, {0.0}, {1.0}), -804.6084420137538, 1e-9);
  // Both branches meet: log Phi is smooth over z = -20, where its slope is 20.0498; values of 203
  // are rounded to 3e-14 and the series is cut at 3e-12.
  const double left = LogLikelihood({1.0, 0.0}, {-20.0 - 1e-7}, {0.0}, {1.0});
  const double right = LogLikelihood({1.0, 0.0}, {-20.0 + 1e-7}, {0.0}, {1.0});
  EXPECT_NEAR(right - left, 2e-7 * 20.0498, 1e-11);
}

// The same with the prior of a.
double Objective(const SquashParameters& at, const Sample& sample) {
  const double t = std::log(at.a);
  return LogLikelihood(at, sample.means, sample.variances, sample.labels) - t * t / 8.0;
}

TEST(FitSquash, FindsTheMaximum) {
  const Sample sample = DrawSample(4000, 7);
  const auto fit = Value(FitSquash(sample.means, sample.variances, sample.labels, {1.0, 0.0}));
  // Standard errors of a and b over 4000 points are about 0.1 and 0.05.
  EXPECT_NEAR(fit.a, 2.5, 0.4);
  EXPECT_NEAR(fit.b, -0.4, 0.2);
  for (const double da : {-1e-3, 0.0, 1e-3}) {
    for (const double db : {-1e-3, 0.0, 1e-3}) {
      const SquashParameters near{fit.a + da, fit.b + db};
      // Newton's last step is under 1e-10: the value is the maximum to rounding of 4000 terms.
      EXPECT_LE(Objective(near, sample), Objective(fit, sample) + 1e-9);
    }
  }
  const auto from_afar =
      Value(FitSquash(sample.means, sample.variances, sample.labels, {9.0, 4.0}));
  EXPECT_NEAR(from_afar.a, fit.a, 1e-6);
  EXPECT_NEAR(from_afar.b, fit.b, 1e-6);
}

TEST(FitSquash, SoftLabelsWeightBothClasses) {
  // Four points of label 3/4 count as three of one class and one of the other.
  const std::vector<double> means = {-0.9, -0.8, 0.1, 0.1, 0.1, 0.1, 0.8},
                            variances = {0.1, 0.1, 0.2, 0.2, 0.2, 0.2, 0.3};
  const auto soft = Value(FitSquash(means, variances, {0.0, 0.0, 0.75, 0.75, 0.75, 0.75, 1.0}, {}));
  const auto hard = Value(FitSquash(means, variances, {0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0}, {}));
  // Steps that change an objective of size 4 by less than its rounding, 4 eps, may be refused: with a
  // curvature of at least 0.1, those below sqrt(2 * 4 eps / 0.1).
  constexpr double kTolerance = 1.4e-7;
  EXPECT_NEAR(std::log(soft.a), std::log(hard.a), kTolerance);
  EXPECT_NEAR(soft.b, hard.b, kTolerance);
  EXPECT_GT(soft.a, 0.31);  // not at a bound
  EXPECT_LT(soft.a, 9.9);
}

TEST(FitSquash, SeparableDataAndOneClassStayInBounds) {
  std::vector<double> means, labels;
  for (int i = 0; i < 400; ++i) {
    means.push_back(i < 200 ? -0.5 : 0.5);
    labels.push_back(i < 200 ? 0.0 : 1.0);
  }
  // So large that the likelihood of 400 points still outweighs the prior at a = 10.
  const std::vector<double> variances(400, 1.0);
  EXPECT_DOUBLE_EQ(Value(FitSquash(means, variances, labels, {})).a, 10.0);
  const auto one_class = Value(FitSquash(means, variances, std::vector<double>(400, 1.0), {}));
  EXPECT_GE(one_class.a, 0.3);
  EXPECT_LE(std::abs(one_class.b), 5.0);
  // Means that speak against their labels: a stays positive.
  for (double& label : labels) label = 1.0 - label;
  EXPECT_DOUBLE_EQ(Value(FitSquash(means, variances, labels, {})).a, 0.3);
  EXPECT_DOUBLE_EQ(Value(FitSquash({}, {}, {}, {50.0, 0.0})).a, 10.0);
}

TEST(FitSquash, RefusesBadArguments) {
  const auto message = [](std::vector<double> means, std::vector<double> variances,
                          std::vector<double> labels) {
    const auto fit = FitSquash(means, variances, labels, {1.0, 0.0});
    EXPECT_THAT(fit, IsInvalid());
    return std::string(fit.status().message());
  };
  EXPECT_THAT(message({0.0}, {1.0}, {}), HasSubstr("sizes"));
  EXPECT_THAT(message({0.0, std::nan("")}, {1.0, 1.0}, {0.5, 0.5}), HasSubstr("point 1"));
  EXPECT_THAT(message({0.0}, {-1.0}, {0.5}), HasSubstr("variance -1"));
  EXPECT_THAT(message({0.0}, {1.0}, {1.1}), HasSubstr("label 1.1"));
}

TEST(FitSquash, RefusesAStartThatIsNoParameters) {
  const Sample sample = DrawSample(20, 3);
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const SquashParameters& start :
       {SquashParameters{nan, 0.0}, SquashParameters{1.0, nan}, SquashParameters{infinity, 0.0},
        SquashParameters{0.0, 0.0}, SquashParameters{1.0, -infinity}}) {
    EXPECT_THAT(FitSquash(sample.means, sample.variances, sample.labels, start),
                IsInvalid("start"));
  }
}

// Probabilistic least-squares classification of handwritten digits, threes against fives, as in
// Rasmussen & Williams, 3.7.3 and 6.5 (there on USPS): even rows for training, odd ones for
// testing.

constexpr int kPixels = 64;

struct Digits {
  RowMatrix pixels;             // in [-1, 1]
  std::vector<double> targets;  // +1: three
};

// Every second digit, from `first` on.
Digits ReadDigits(int first) {
  std::ifstream file("tests/gp/calibration/testdata/digits_3_5.txt");
  std::vector<double> pixels;
  Digits digits;
  std::string line;
  for (int row = 0; std::getline(file, line);) {
    if (line[0] == '#' || row++ % 2 != first) continue;
    digits.targets.push_back(line[0] == '3' ? 1.0 : -1.0);
    for (int i = 0; i < kPixels; ++i) pixels.push_back((line[2 + i] - 'a') / 8.0 - 1.0);
  }
  digits.pixels = Eigen::Map<RowMatrix>(pixels.data(), digits.targets.size(), kPixels);
  return digits;
}

// sigma_f^2 exp(-|x - x'|^2 / (2 l^2)).
RowMatrix Covariance(const RowMatrix& a, const RowMatrix& b, double length, double signal) {
  RowMatrix k(a.rows(), b.rows());
  for (int64_t i = 0; i < a.rows(); ++i) {
    for (int64_t j = 0; j < b.rows(); ++j) {
      k(i, j) = signal * signal *
                std::exp(-0.5 * (a.row(i) - b.row(j)).squaredNorm() / (length * length));
    }
  }
  return k;
}

struct RegressionFit {
  double length, signal, noise;
  double log_likelihood = -std::numeric_limits<double>::infinity();
  IncrementalCholesky factor;
  RowMatrix alpha;
};

// The regression of the best marginal likelihood on a grid.
RegressionFit FitRegression(const Digits& digits) {
  RegressionFit best;
  const int64_t n = digits.pixels.rows();
  for (const double length : {1.5, 2.0, 3.0, 4.0, 6.0}) {
    for (const double signal : {0.7, 1.0, 1.5, 2.0}) {
      for (const double noise : {0.03, 0.1, 0.2}) {
        RowMatrix k = Covariance(digits.pixels, digits.pixels, length, signal);
        k.diagonal().array() += noise * noise;
        IncrementalCholesky factor = FactorOf(k);
        const RowMatrix y = Eigen::Map<const RowMatrix>(digits.targets.data(), n, 1);
        RowMatrix alpha = y;
        SolveLower(factor.Factor(), ViewOf(alpha));
        SolveLowerTransposed(factor.Factor(), ViewOf(alpha));
        const double likelihood = -0.5 * ((y.transpose() * alpha)(0, 0) + factor.LogDeterminant());
        if (likelihood > best.log_likelihood) {
          best = {length, signal, noise, likelihood, std::move(factor), alpha};
        }
      }
    }
  }
  return best;
}

TEST(Digits, ThreesAgainstFives) {
  const Digits training = ReadDigits(0), testing = ReadDigits(1);
  ASSERT_EQ(training.targets.size(), 183u);
  ASSERT_EQ(testing.targets.size(), 182u);
  const RegressionFit fit = FitRegression(training);
  const std::vector<double> alpha(fit.alpha.data(), fit.alpha.data() + fit.alpha.size());
  const auto left_out = Value(ComputeLeaveOneOut(fit.factor, training.targets, alpha));
  std::vector<double> labels;
  for (const double y : training.targets) labels.push_back(y > 0.0 ? 1.0 : 0.0);
  const auto squash = Value(
      FitSquash(left_out.mean, left_out.LatentVariance(fit.noise * fit.noise), labels, {1.0, 0.0}));

  const RowMatrix cross = Covariance(testing.pixels, training.pixels, fit.length, fit.signal);
  RowMatrix half = cross.transpose();
  SolveLower(fit.factor.Factor(), ViewOf(half));
  const RowMatrix mean = cross * fit.alpha;
  int errors = 0;
  double information = 0.0;
  for (int64_t i = 0; i < mean.rows(); ++i) {
    const double variance = fit.signal * fit.signal - half.col(i).squaredNorm();
    const double p = squash.Probability(mean(i, 0), std::max(0.0, variance));
    const bool is_three = testing.targets[i] > 0.0;
    errors += (p > 0.5) != is_three;
    information += 1.0 + std::log2(is_three ? p : 1.0 - p);
  }
  RecordProperty("errors", errors);
  EXPECT_LE(errors, 3);
  // Bits a digit that the probabilities tell about the class, of 1 (R & W, fig. 3.7): a classifier
  // that is right but badly calibrated fails this.
  EXPECT_GT(information / static_cast<double>(mean.rows()), 0.8);
}

}  // namespace
}  // namespace egosieve::gp
