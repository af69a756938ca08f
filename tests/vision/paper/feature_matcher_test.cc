#include "vision/paper/feature_matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/features2d.hpp>
#include <random>
#include <vector>

namespace egosieve::vision {
namespace {

constexpr int kThreads = 2;

// `count` features at random places; those of the second set are noisy copies in another order.
struct Sets {
  FeatureSet first, second;
  std::vector<int> truth;  // index in second of each of first
};

Sets MakeSets(int count, int key_points, int noise) {
  std::mt19937_64 engine(3);
  Sets sets;
  sets.truth.resize(count);
  for (int i = 0; i < count; ++i) sets.truth[i] = i;
  // Kinds stay together.
  std::shuffle(sets.truth.begin(), sets.truth.begin() + key_points, engine);
  std::shuffle(sets.truth.begin() + key_points, sets.truth.end(), engine);
  for (FeatureSet* set : {&sets.first, &sets.second}) {
    set->positions.resize(count);
    set->descriptors.resize(static_cast<size_t>(count) * kSiftDescriptorBytes);
    set->key_point_count = key_points;
  }
  for (int i = 0; i < count; ++i) {
    const int j = sets.truth[i];
    sets.first.positions[i] = cv::Point2f(engine() % 800, engine() % 300);
    sets.second.positions[j] = sets.first.positions[i] + cv::Point2f(5, -3);
    for (int k = 0; k < kSiftDescriptorBytes; ++k) {
      const int value = static_cast<int>(engine() % 200);
      const int other = value + static_cast<int>(engine() % (2 * noise + 1)) - noise;
      sets.first.descriptors[i * kSiftDescriptorBytes + k] = static_cast<uint8_t>(value);
      sets.second.descriptors[j * kSiftDescriptorBytes + k] =
          static_cast<uint8_t>(std::clamp(other, 0, 255));
    }
  }
  return sets;
}

bool SameMatches(const std::vector<Match>& a, const std::vector<Match>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](auto& x, auto& y) {
           return x.first == y.first && x.second == y.second;
         });
}

TEST(MatchFeatures, FindsNoisyCopies) {
  const Sets sets = MakeSets(400, 250, 20);
  const auto matches = MatchFeatures(sets.first, sets.second, kThreads);
  ASSERT_EQ(matches.size(), 400u);
  for (const Match& match : matches) {
    EXPECT_EQ(match.second, sets.truth[match.first]);
    EXPECT_EQ(match.first < 250, match.second < 250) << "kinds are matched apart";
  }
}

// The same matches as OpenCV's exhaustive matcher, two nearest and cross-check, on features of one
// kind.
TEST(MatchFeatures, EqualsOpenCvBruteForce) {
  const int count = 500;
  const Sets sets = MakeSets(count, count, 130);
  const double ratio = 0.8;
  const auto to_floats = [&](const FeatureSet& set) {
    cv::Mat bytes(count, kSiftDescriptorBytes, CV_8U, const_cast<uint8_t*>(set.descriptor(0)));
    cv::Mat floats;
    bytes.convertTo(floats, CV_32F);
    return floats;
  };
  const cv::Mat a = to_floats(sets.first), b = to_floats(sets.second);
  std::vector<std::vector<cv::DMatch>> forward;
  std::vector<cv::DMatch> backward;
  cv::BFMatcher matcher(cv::NORM_L2);
  matcher.knnMatch(a, b, forward, 2);
  matcher.match(b, a, backward);
  std::vector<std::pair<int, int>> expected, found;
  for (int i = 0; i < count; ++i) {
    const cv::DMatch& best = forward[i][0];
    const bool distinct = best.distance < ratio * forward[i][1].distance;
    if (distinct && backward[best.trainIdx].trainIdx == i) expected.push_back({i, best.trainIdx});
  }
  for (const Match& match : MatchFeatures(sets.first, sets.second, kThreads))
    found.push_back({match.first, match.second});
  EXPECT_EQ(found, expected);
  EXPECT_GT(found.size(), 20u);
  EXPECT_LT(found.size(), static_cast<size_t>(count)) << "the ratio test was never decisive";
}

TEST(MatchFeatures, SameForAnyNumberOfThreads) {
  const Sets sets = MakeSets(1500, 900, 90);
  const auto one = MatchFeatures(sets.first, sets.second, 1);
  for (const int threads : {2, 4}) {
    EXPECT_TRUE(SameMatches(one, MatchFeatures(sets.first, sets.second, threads)));
  }
}

TEST(MatchFeatures, EmptySets) {
  const Sets sets = MakeSets(3, 3, 10);
  EXPECT_TRUE(MatchFeatures({}, sets.second, kThreads).empty());
  EXPECT_TRUE(MatchFeatures(sets.first, {}, kThreads).empty());
}

}  // namespace
}  // namespace egosieve::vision
