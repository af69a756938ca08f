#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <opencv2/features2d.hpp>
#include <random>
#include <vector>

#include "tests/testing/status.h"
#include "tests/vision/features/textured_image.h"
#include "vision/paper/descriptor_search.h"
#include "vision/paper/feature_extractor.h"
#include "vision/paper/feature_matcher.h"
#include "vision/paper/feature_set.h"
#include "vision/paper/neighbour_agreement.h"

namespace egosieve::vision {
namespace {

using testing::TexturedImage;

constexpr int kThreads = 2;

TEST(ExtractFeatures, TheirNumberFollowsTheAreaSpreadEvenlyAndInside) {
  const auto features = Value(ExtractFeatures(TexturedImage(621, 375, 1)));
  EXPECT_EQ(features.size(), 3500);
  EXPECT_EQ(features.descriptors.size(), 3500u * kSiftDescriptorBytes);
  std::map<int, int> in_cell;  // of 8 x 4
  for (const cv::Point2f& p : features.positions) {
    ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.x <= 620 && p.y <= 374);
    ++in_cell[static_cast<int>(p.x / 78) * 4 + static_cast<int>(p.y / 94)];
  }
  EXPECT_EQ(in_cell.size(), 32u);
  for (const auto& [cell, count] : in_cell) EXPECT_GT(count, 3500 / 32 / 3) << cell;
}

TEST(ExtractFeatures, FlatTinyAndWrongImages) {
  const auto flat = Value(ExtractFeatures(cv::Mat(90, 120, CV_8U, cv::Scalar(77))));
  EXPECT_EQ(flat.size(), 0);
  for (const int side : {1, 2, 7, 16, 40}) {
    EXPECT_TRUE(ExtractFeatures(TexturedImage(side, side, 3)).ok()) << side;
    EXPECT_TRUE(ExtractFeatures(TexturedImage(300, side, 3)).ok()) << side;
  }
  EXPECT_FALSE(ExtractFeatures(cv::Mat()).ok());
  EXPECT_FALSE(ExtractFeatures(cv::Mat(20, 20, CV_8UC3)).ok());
}

// Of two pictures, the second 7 pixels to the right and 5 down, both kinds are found again.
TEST(ExtractFeatures, PlacesAreFoundAgain) {
  const cv::Mat image = TexturedImage(407, 305, 4);
  const auto first = Value(ExtractFeatures(image(cv::Rect(0, 0, 400, 300))));
  const auto second = Value(ExtractFeatures(image(cv::Rect(7, 5, 400, 300))));
  int key_points = 0, corners = 0, right = 0;
  for (const Match& match : MatchFeatures(first, second, kThreads)) {
    (match.first < first.key_point_count ? key_points : corners) += 1;
    const cv::Point2f moved = first.positions[match.first] - second.positions[match.second];
    right += cv::norm(moved - cv::Point2f(7, 5)) < 1.0;
  }
  EXPECT_GT(key_points, first.key_point_count / 2);
  EXPECT_GT(corners, (first.size() - first.key_point_count) / 2);
  EXPECT_GT(right, 0.95 * (key_points + corners));
}

constexpr int kBytes = 128;

enum class Values { kRandom, kFew, kExtreme };

std::vector<uint8_t> Descriptors(int64_t count, Values values, uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<uint8_t> bytes(count * kBytes);
  std::vector<uint8_t> palette = {0, 255};
  for (int64_t i = 0; i < count; ++i) {
    const uint64_t pattern = engine() % 3;  // kFew: of three descriptors, so that ties abound
    std::mt19937_64 few(pattern);
    for (int k = 0; k < kBytes; ++k) {
      uint8_t& byte = bytes[i * kBytes + k];
      switch (values) {
        case Values::kRandom:
          byte = static_cast<uint8_t>(engine());
          break;
        case Values::kFew:
          byte = static_cast<uint8_t>(few());
          break;
        case Values::kExtreme:
          byte = palette[i % 2];
          break;
      }
    }
  }
  return bytes;
}

int64_t PlainDistance(const uint8_t* a, const uint8_t* b) {
  int64_t sum = 0;
  for (int k = 0; k < kBytes; ++k) sum += (int64_t{a[k]} - b[k]) * (int64_t{a[k]} - b[k]);
  return sum;
}

// The definition, word by word.
NearestBothWays PlainSearch(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  const int64_t rows = a.size() / kBytes, columns = b.size() / kBytes;
  NearestBothWays result;
  result.rows.resize(rows);
  result.columns.assign(columns, -1);
  std::vector<int64_t> column_distance(columns, kNoDistance);
  for (int64_t i = 0; i < rows; ++i) {
    Nearest& nearest = result.rows[i];
    for (int64_t j = 0; j < columns; ++j) {
      const int32_t d = static_cast<int32_t>(PlainDistance(&a[i * kBytes], &b[j * kBytes]));
      if (d < nearest.distance) {
        nearest = {static_cast<int32_t>(j), d, nearest.distance};
      } else if (d < nearest.second_distance) {
        nearest.second_distance = d;
      }
      if (d < column_distance[j]) {
        column_distance[j] = d;
        result.columns[j] = static_cast<int32_t>(i);
      }
    }
  }
  return result;
}

void ExpectSame(const NearestBothWays& a, const NearestBothWays& b) {
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (size_t i = 0; i < a.rows.size(); ++i) {
    EXPECT_EQ(a.rows[i].index, b.rows[i].index) << i;
    EXPECT_EQ(a.rows[i].distance, b.rows[i].distance) << i;
    EXPECT_EQ(a.rows[i].second_distance, b.rows[i].second_distance) << i;
  }
  EXPECT_EQ(a.columns, b.columns);
}

TEST(SearchDescriptors, EqualsTheDefinitionAtEverySize) {
  for (const Values values : {Values::kRandom, Values::kFew, Values::kExtreme}) {
    for (const int64_t rows : {0, 1, 3, 4, 5, 255, 256, 257, 600}) {
      for (const int64_t columns : {0, 1, 2, 15, 16, 17, 31, 32, 33, 127, 129, 300}) {
        const auto a = Descriptors(rows, values, 1), b = Descriptors(columns, values, 2);
        SCOPED_TRACE(::testing::Message() << rows << " x " << columns);
        const NearestBothWays plain = PlainSearch(a, b);
        ExpectSame(SearchDescriptors(a.data(), rows, b.data(), columns, 1), plain);
        ExpectSame(SearchDescriptors(a.data(), rows, b.data(), columns, 4), plain);
      }
    }
  }
}

TEST(SquaredDistance, ExtremesDoNotOverflow) {
  const std::vector<uint8_t> zeros(kBytes, 0), ones(kBytes, 255);
  EXPECT_EQ(SquaredDistance(zeros.data(), ones.data()), 128 * 255 * 255);
  EXPECT_EQ(SquaredDistance(ones.data(), ones.data()), 0);
}

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

// Two motions side by side and false matches among them.
TEST(AgreesWithNeighbours, KeepsWorldAndMoverAndDropsFalseMatches) {
  std::mt19937_64 engine(5);
  const auto uniform = [&](double most) {
    return most * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  std::vector<PointPair> pairs;
  std::vector<bool> is_false;
  for (int i = 0; i < 2000; ++i) {
    const double x = uniform(800), y = uniform(300);
    const bool mover = x > 300 && x < 420 && y > 100 && y < 200;
    PointPair pair{x, y, x + (mover ? -25 : 4) + uniform(1), y + 2 + uniform(1)};
    is_false.push_back(i % 10 == 0);
    if (is_false.back()) {
      pair.x2 = uniform(800);
      pair.y2 = uniform(300);
    }
    pairs.push_back(pair);
  }
  const std::vector<uint8_t> agrees = AgreesWithNeighbours(pairs, {});
  int kept_false = 0, dropped_true = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    kept_false += is_false[i] && agrees[i] != 0;
    dropped_true += !is_false[i] && agrees[i] == 0;
  }
  // About 42 neighbours each, 4 of them false and so to within about 15 pixels in 240,000 square
  // pixels.
  EXPECT_LE(kept_false, 10) << "of 200";
  EXPECT_LE(dropped_true, 5) << "of 1800";
}

TEST(AgreesWithNeighbours, FewAndWildPairs) {
  EXPECT_TRUE(AgreesWithNeighbours({}, {}).empty());
  EXPECT_EQ(AgreesWithNeighbours({{1, 1, 2, 2}}, {}), std::vector<uint8_t>({0}));
  const NeighbourAgreementOptions alone{.minimum_neighbours = 0};
  EXPECT_EQ(AgreesWithNeighbours({{1, 1, 2, 2}, {NAN, 1, 2, 2}, {1e300, 1, 2, 2}}, alone),
            std::vector<uint8_t>({1, 0, 0}));
  // Across the origin, where cells change sign.
  EXPECT_EQ(AgreesWithNeighbours({{-1, -1, 0, 0}, {1, 1, 2, 2}}, {.minimum_neighbours = 1}),
            std::vector<uint8_t>({1, 1}));
}

}  // namespace
}  // namespace egosieve::vision
