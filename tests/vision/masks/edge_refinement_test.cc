#include "vision/masks/edge_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/core.hpp>

namespace egosieve::vision {
namespace {

constexpr int kRows = 7, kColumns = 9;

double Likeness(const cv::Vec3b& a, const cv::Vec3b& b) {
  return std::exp(-cv::norm(cv::Vec3d(a) - cv::Vec3d(b)) / 5.0);
}

// Solves (ER2) along a line of the picture by a dense matrix.
Eigen::VectorXd SolveLine(const cv::Mat3b& line, const Eigen::VectorXd& values, double weight) {
  const int n = static_cast<int>(values.size());
  Eigen::MatrixXd system = Eigen::MatrixXd::Identity(n, n);
  for (int i = 0; i + 1 < n; ++i) {
    Eigen::VectorXd difference = Eigen::VectorXd::Zero(n);
    difference(i) = 1.0;
    difference(i + 1) = -1.0;
    system += weight * Likeness(line(i), line(i + 1)) * difference * difference.transpose();
  }
  return system.ldlt().solve(values);
}

struct Example {
  cv::Mat3b image = cv::Mat3b(kRows, kColumns);  // from black to white, in steps of 15
  cv::Mat1f log_odds = cv::Mat1f(kRows, kColumns);
};

Example Random() {
  cv::RNG rng(3);
  Example example;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const int base = x < 4 ? 60 : 90;
      example.image(y, x) = {static_cast<uchar>(base + 15 * rng.uniform(0, 2)),
                             static_cast<uchar>(base),
                             static_cast<uchar>(base + 15 * rng.uniform(0, 2))};
      example.log_odds(y, x) = rng.uniform(-4.0f, 4.0f);
    }
  }
  example.image(0, 0) = example.image(0, 4) = {0, 0, 0};  // twice: one in a thousand may be outside
  example.image(4, 0) = example.image(4, 4) = {255, 255, 255};
  return example;
}

TEST(EdgeRefinement, SolvesRowsAndColumnsInTurn) {
  const auto& [image, log_odds] = Random();
  Eigen::MatrixXd expected(kRows, kColumns);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) expected(y, x) = 1.0 / (1.0 + std::exp(-log_odds(y, x)));
  }
  double weight = std::pow(0.05 * kColumns, 2);
  for (int sweep = 0; sweep < 3; ++sweep) {
    for (int y = 0; y < kRows; ++y) {
      expected.row(y) = SolveLine(image.row(y).t(), expected.row(y).transpose(), weight);
    }
    for (int x = 0; x < kColumns; ++x) {
      expected.col(x) = SolveLine(image.col(x).clone(), expected.col(x), weight);
    }
    weight /= 4.0;
  }
  const cv::Mat1f refined = RefineProbability(image, log_odds);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) EXPECT_NEAR(refined(y, x), expected(y, x), 1e-5);
  }
}

TEST(EdgeRefinement, TheDarkerPictureHasTheSameEdges) {
  const auto& [image, log_odds] = Random();
  const cv::Mat3b dark = image / 3, darker = image / 5;
  EXPECT_LT(cv::norm(RefineProbability(dark, log_odds), RefineProbability(darker, log_odds),
                     cv::NORM_INF),
            1e-6);
}

}  // namespace
}  // namespace egosieve::vision
