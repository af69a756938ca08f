// Probabilistic least-squares classification of handwritten digits, threes against fives, as in
// Rasmussen & Williams, 3.7.3 and 6.5 (there on USPS): even rows for training, odd ones for
// testing.
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "gp/calibration/leave_one_out.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/incremental_cholesky.h"
#include "gtest/gtest.h"
#include "tests/gp/linalg/random_matrices.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

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

struct Fit {
  double length, signal, noise;
  double log_likelihood = -std::numeric_limits<double>::infinity();
  IncrementalCholesky factor;
  RowMatrix alpha;
};

// The regression of the best marginal likelihood on a grid.
Fit FitRegression(const Digits& digits) {
  Fit best;
  const int64_t n = digits.pixels.rows();
  for (const double length : {1.5, 2.0, 3.0, 4.0, 6.0}) {
    for (const double signal : {0.7, 1.0, 1.5, 2.0}) {
      for (const double noise : {0.03, 0.1, 0.2}) {
        RowMatrix k = Covariance(digits.pixels, digits.pixels, length, signal);
        k.diagonal().array() += noise * noise;
        IncrementalCholesky factor;
        EXPECT_TRUE(factor.Factorize(ViewOf(k)).ok());
        const RowMatrix y = Eigen::Map<const RowMatrix>(digits.targets.data(), n, 1);
        RowMatrix alpha = y;
        EXPECT_TRUE(factor.Solve(ViewOf(alpha)).ok());
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
  const Fit fit = FitRegression(training);
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
    const double p = squash.parameters.Probability(mean(i, 0), std::max(0.0, variance));
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
