// Exact nearest neighbours among SIFT descriptors of 128 bytes, by squared Euclidean distance in
// whole numbers: the same on every machine. Cost: 2 n m 128 multiply-adds.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace egosieve::vision {

inline constexpr int32_t kNoDistance = std::numeric_limits<int32_t>::max();

struct Nearest {
  int32_t index = -1;                     // -1: nothing to compare with
  int32_t distance = kNoDistance;         // squared; of the nearest, the lowest index where equal
  int32_t second_distance = kNoDistance;  // squared; of the nearest other than `index`
};

struct NearestBothWays {
  std::vector<Nearest> rows;     // for each a: its two nearest b
  std::vector<int32_t> columns;  // for each b: index of its nearest a, the lowest if equal
};

// a: rows x 128 bytes, b: columns x 128 bytes, row-major. The result does not depend on `threads`.
NearestBothWays SearchDescriptors(const uint8_t* a, int64_t rows, const uint8_t* b, int64_t columns,
                                  int threads);

// |a - b|^2 of two descriptors.
int32_t SquaredDistance(const uint8_t* a, const uint8_t* b);

}  // namespace egosieve::vision
