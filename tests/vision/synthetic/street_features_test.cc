// What a feature detector finds in synthetic frames, noise and motion blur included.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <string>
#include <vector>

#include "tests/vision/synthetic/fundamental_matrix.h"
#include "vision/synthetic/camera.h"
#include "vision/synthetic/street.h"

namespace egosieve::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Distance of (x2, y2) from the epipolar line of (x1, y1), pixels.
double EpipolarDistance(const Eigen::Matrix3d& f, const Vector2d& p1, const Vector2d& p2) {
  const Vector3d line = f * p1.homogeneous();
  return std::abs(line.dot(p2.homogeneous())) / line.head<2>().norm();
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

class StreetFeaturesTest : public ::testing::TestWithParam<const char*> {};

struct Matches {
  std::vector<Vector2d> first, second;
};

Matches SiftMatches(const cv::Mat& first, const cv::Mat& second) {
  const auto sift = cv::SIFT::create();
  std::vector<cv::KeyPoint> a, b;
  cv::Mat da, db;
  sift->detectAndCompute(first, cv::noArray(), a, da);
  sift->detectAndCompute(second, cv::noArray(), b, db);
  std::vector<std::vector<cv::DMatch>> pairs;
  cv::BFMatcher(cv::NORM_L2).knnMatch(da, db, pairs, 2);
  Matches matches;
  for (const auto& pair : pairs) {
    if (pair.size() < 2 || !(pair[0].distance < 0.8f * pair[1].distance)) continue;
    const cv::Point2f p = a[pair[0].queryIdx].pt, q = b[pair[0].trainIdx].pt;
    matches.first.emplace_back(p.x, p.y);
    matches.second.emplace_back(q.x, q.y);
  }
  return matches;
}

// As natural as a street is to a feature detector; and the matches between static pixels lie on the
// epipolar lines of the poses.
TEST_P(StreetFeaturesTest, SiftFindsAndMatchesEnough) {
  ScenarioOptions options;
  options.frames_per_second = 15.0;
  const Scenario scenario = *MakeScenario(GetParam(), 3, options);
  double sum = 0.0;
  const std::vector<int> times = {20, 80, 140};
  for (const int t : times) {
    const SyntheticFrame first = *scenario.Render(t), second = *scenario.Render(t + 1);
    const Matches matches = SiftMatches(first.image, second.image);
    EXPECT_GE(matches.first.size(), 1200u) << "frame " << t;
    sum += static_cast<double>(matches.first.size());
    const Eigen::Matrix3d f = FundamentalMatrix(scenario.intrinsics(), first.pose, second.pose);
    std::vector<double> distances;
    for (size_t i = 0; i < matches.first.size(); ++i) {
      const cv::Point p(std::lround(matches.first[i].x()), std::lround(matches.first[i].y()));
      if (first.mask.at<uint8_t>(p) == 0) {
        distances.push_back(EpipolarDistance(f, matches.first[i], matches.second[i]));
      }
    }
    // SIFT localises to a few tenths of a pixel.
    EXPECT_LT(Median(distances), 0.4) << "frame " << t;
  }
  EXPECT_GE(sum / static_cast<double>(times.size()), 1500.0);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, StreetFeaturesTest, ::testing::Values("street", "handheld"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace egosieve::vision
