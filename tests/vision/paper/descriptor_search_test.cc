#include "vision/paper/descriptor_search.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

namespace egosieve::vision {
namespace {

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

}  // namespace
}  // namespace egosieve::vision
