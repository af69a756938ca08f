#include "vision/matching/descriptor_search.h"

#include <algorithm>
#include <cstring>

#if defined(__AVX512VNNI__) && defined(__AVX512BW__)
#include <immintrin.h>
#define EGOSIEVE_VNNI 1
#endif

#include "kernels/base/parallel_for.h"
#include "vision/features/feature_set.h"

namespace egosieve::vision {
namespace {

constexpr int kBytes = kSiftDescriptorBytes;
constexpr int64_t kRowsPerTask = 256;

struct ColumnBest {
  std::vector<int32_t> distance, index;
  explicit ColumnBest(int64_t n) : distance(n, kNoDistance), index(n, -1) {}
};

#ifdef EGOSIEVE_VNNI

constexpr int kLanes = 16;
constexpr int kRowBlock = 4;
constexpr int kPanelsPerChunk = 8;  // 16 KiB of b stay in the first-level cache for all rows

// b, offset by -128 and transposed in panels of 16 columns: panel[k][lane][4] holds bytes 4 k .. 4
// k + 3.
struct Panels {
  int64_t count = 0;  // even; columns beyond the last are padding
  std::vector<int8_t> bytes;
  std::vector<int32_t> norm;  // |b|^2; kPadding for padding

  static constexpr int32_t kPadding = 1 << 29;
  const int8_t* panel(int64_t p) const { return bytes.data() + p * kLanes * kBytes; }
};

Panels MakePanels(const uint8_t* b, int64_t columns) {
  Panels panels;
  panels.count = (columns + 2 * kLanes - 1) / (2 * kLanes) * 2;
  panels.bytes.assign(panels.count * kLanes * kBytes, 0);
  panels.norm.assign(panels.count * kLanes, Panels::kPadding);
  for (int64_t j = 0; j < columns; ++j) {
    int8_t* out = panels.bytes.data() + j / kLanes * kLanes * kBytes + j % kLanes * 4;
    int32_t norm = 0;
    for (int k = 0; k < kBytes; ++k) {
      const int value = b[j * kBytes + k];
      norm += value * value;
      out[k / 4 * kLanes * 4 + k % 4] = static_cast<int8_t>(value - 128);
    }
    panels.norm[j] = norm;
  }
  return panels;
}

// The two smallest of each of 16 residue classes of columns, for one row.
struct alignas(64) LaneState {
  int32_t first[kLanes], second[kLanes], index[kLanes];
};

Nearest Reduce(const LaneState& state, int64_t columns) {
  Nearest nearest;
  int winner = -1;
  for (int lane = 0; lane < kLanes; ++lane) {
    if (state.index[lane] < 0 || state.index[lane] >= columns) continue;
    const bool better =
        state.first[lane] < nearest.distance ||
        (state.first[lane] == nearest.distance && state.index[lane] < nearest.index);
    if (winner < 0 || better) {
      winner = lane;
      nearest.distance = state.first[lane];
      nearest.index = state.index[lane];
    }
  }
  if (winner < 0) return nearest;
  int32_t second = state.second[winner];
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lane != winner) second = std::min(second, state.first[lane]);
  }
  nearest.second_distance = second >= Panels::kPadding / 2 ? kNoDistance : second;
  return nearest;
}

// Dot products of kRowBlock rows of a with two panels.
inline void MultiplyPanels(const uint8_t* const* a, const int8_t* panel,
                           __m512i (&sums)[kRowBlock][2]) {
  for (auto& row : sums) row[0] = row[1] = _mm512_setzero_si512();
  for (int k = 0; k < kBytes / 4; ++k) {
    const __m512i b0 = _mm512_loadu_si512(panel + k * 64);
    const __m512i b1 = _mm512_loadu_si512(panel + kLanes * kBytes + k * 64);
    for (int r = 0; r < kRowBlock; ++r) {
      int32_t four;
      std::memcpy(&four, a[r] + 4 * k, 4);
      const __m512i broadcast = _mm512_set1_epi32(four);
      sums[r][0] = _mm512_dpbusd_epi32(sums[r][0], broadcast, b0);
      sums[r][1] = _mm512_dpbusd_epi32(sums[r][1], broadcast, b1);
    }
  }
}

inline void UpdateRow(__m512i distance, __m512i column, LaneState& state) {
  const __m512i first = _mm512_load_si512(state.first);
  const __m512i second = _mm512_load_si512(state.second);
  const __mmask16 closer = _mm512_cmplt_epi32_mask(distance, first);
  _mm512_store_si512(state.second, _mm512_min_epi32(second, _mm512_max_epi32(first, distance)));
  _mm512_store_si512(state.first, _mm512_min_epi32(first, distance));
  _mm512_mask_store_epi32(state.index, closer, column);
}

// The rows [begin, end) against all panels. Rows come in increasing order, so that "closer than"
// leaves the lowest row where distances are equal.
void SearchRows(const uint8_t* a, int64_t begin, int64_t end, const Panels& panels, int64_t columns,
                Nearest* rows, ColumnBest& best) {
  const int64_t count = end - begin;
  std::vector<LaneState> states(count);
  std::vector<int32_t> row_constant(count);
  for (int64_t i = 0; i < count; ++i) {
    std::fill_n(states[i].first, kLanes, kNoDistance);
    std::fill_n(states[i].second, kLanes, kNoDistance);
    std::fill_n(states[i].index, kLanes, -1);
    int32_t constant = 0;
    for (int k = 0; k < kBytes; ++k) {
      const int value = a[(begin + i) * kBytes + k];
      constant += value * value - 256 * value;
    }
    row_constant[i] = constant;
  }
  const __m512i lane_numbers =
      _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  for (int64_t chunk = 0; chunk < panels.count; chunk += kPanelsPerChunk) {
    const int64_t chunk_end = std::min(chunk + kPanelsPerChunk, panels.count);
    for (int64_t i = 0; i < count; i += kRowBlock) {
      const uint8_t* block[kRowBlock];
      for (int r = 0; r < kRowBlock; ++r) {
        block[r] = a + (begin + std::min(i + r, count - 1)) * kBytes;
      }
      const int used = static_cast<int>(std::min<int64_t>(kRowBlock, count - i));
      for (int64_t p = chunk; p < chunk_end; p += 2) {
        __m512i sums[kRowBlock][2];
        MultiplyPanels(block, panels.panel(p), sums);
        for (int half = 0; half < 2; ++half) {
          const int64_t column = (p + half) * kLanes;
          const __m512i norm = _mm512_loadu_si512(panels.norm.data() + column);
          const __m512i numbers =
              _mm512_add_epi32(_mm512_set1_epi32(static_cast<int32_t>(column)), lane_numbers);
          __m512i column_distance = _mm512_loadu_si512(best.distance.data() + column);
          __m512i column_index = _mm512_loadu_si512(best.index.data() + column);
          for (int r = 0; r < used; ++r) {
            const __m512i distance =
                _mm512_sub_epi32(_mm512_add_epi32(norm, _mm512_set1_epi32(row_constant[i + r])),
                                 _mm512_slli_epi32(sums[r][half], 1));
            UpdateRow(distance, numbers, states[i + r]);
            const __mmask16 closer = _mm512_cmplt_epi32_mask(distance, column_distance);
            column_distance = _mm512_min_epi32(distance, column_distance);
            column_index =
                _mm512_mask_set1_epi32(column_index, closer, static_cast<int32_t>(begin + i + r));
          }
          _mm512_storeu_si512(best.distance.data() + column, column_distance);
          _mm512_storeu_si512(best.index.data() + column, column_index);
        }
      }
    }
  }
  for (int64_t i = 0; i < count; ++i) rows[begin + i] = Reduce(states[i], columns);
}

#else

struct Panels {
  int64_t count = 0;
  const uint8_t* bytes = nullptr;
};

Panels MakePanels(const uint8_t* b, int64_t columns) { return {columns, b}; }

constexpr int kLanes = 1;

void SearchRows(const uint8_t* a, int64_t begin, int64_t end, const Panels& panels, int64_t columns,
                Nearest* rows, ColumnBest& best) {
  for (int64_t i = begin; i < end; ++i) {
    Nearest nearest;
    for (int64_t j = 0; j < columns; ++j) {
      const int32_t distance = SquaredDistance(a + i * kBytes, panels.bytes + j * kBytes);
      if (distance < nearest.distance) {
        nearest.second_distance = nearest.distance;
        nearest.distance = distance;
        nearest.index = static_cast<int32_t>(j);
      } else {
        nearest.second_distance = std::min(nearest.second_distance, distance);
      }
      if (distance < best.distance[j]) {
        best.distance[j] = distance;
        best.index[j] = static_cast<int32_t>(i);
      }
    }
    rows[i] = nearest;
  }
}

#endif

}  // namespace

int32_t SquaredDistance(const uint8_t* a, const uint8_t* b) {
  int32_t sum = 0;
  for (int k = 0; k < kBytes; ++k) {
    const int32_t difference = static_cast<int32_t>(a[k]) - static_cast<int32_t>(b[k]);
    sum += difference * difference;
  }
  return sum;
}

NearestBothWays SearchDescriptors(const uint8_t* a, int64_t rows, const uint8_t* b, int64_t columns,
                                  int threads) {
  NearestBothWays result;
  result.rows.resize(rows);
  result.columns.assign(columns, -1);
  if (rows == 0 || columns == 0) return result;
  const Panels panels = MakePanels(b, columns);
  const int64_t tasks = (rows + kRowsPerTask - 1) / kRowsPerTask;
  const int64_t padded_columns = panels.count * kLanes;
  std::vector<ColumnBest> best(tasks, ColumnBest(padded_columns));
  kernels::ParallelFor(tasks, {.threads = threads}, [&](int64_t task) {
    const int64_t begin = task * kRowsPerTask;
    SearchRows(a, begin, std::min(begin + kRowsPerTask, rows), panels, columns, result.rows.data(),
               best[task]);
  });
  std::vector<int32_t> distance(columns, kNoDistance);
  for (const ColumnBest& task : best) {
    for (int64_t j = 0; j < columns; ++j) {
      if (task.distance[j] < distance[j]) {
        distance[j] = task.distance[j];
        result.columns[j] = task.index[j];
      }
    }
  }
  return result;
}

}  // namespace egosieve::vision
