// The dense posterior, tile by tile; kernels/ops/opencl_dense_posterior.cc describes the arrays.
// Macros in addition to common.cl's:
//   PANEL    rows of the factor in a register block
//   WIDTH    vectors of queries in a register block; WIDTH * VEC queries are a micro-tile
//   GROUP    rows of the factor in a cache block, a multiple of PANEL
//   DEPTH    columns of the factor in a cache block; GROUP is a multiple or a divisor of it
//   FACTOR   0 none, 1 Cholesky (blocked substitution), 2 inverse Cholesky (product)
//   WORK_GROUP  work-items side by side, each on its own tiles: 1 on CPUs
// dense_posterior_local.cl does the same on devices whose work-items share local memory.
#define QUERIES (WIDTH * VEC)

#include "posterior_outputs.cl"

// The sums for the means of one micro-tile, and its covariances k*(i, q) / sigma_f^2 if
// `covariances` is not null: n x QUERIES.
static inline void covary(__global const float* queries, const long query_stride, __global const float* inputs,
                   __global const float* alpha, const int n, __global float* covariances,
                   __global float* means) {
  REALV q[WIDTH][POINT];
  REALV total[WIDTH];
#pragma unroll
  for (int v = 0; v < WIDTH; ++v) {
    UNROLL for (int c = 0; c < POINT; ++c) {
      q[v][c] = LOADV(queries + c * query_stride + v * VEC);
    }
    total[v] = (REALV)0;
  }
  for (int block = 0; block < n; block += SUM_BLOCK) {
    const int end = min(block + SUM_BLOCK, n);
    REALV sum[WIDTH];
#pragma unroll
    for (int v = 0; v < WIDTH; ++v) sum[v] = (REALV)0;
    for (int i = block; i < end; ++i) {
      __global const float* x = inputs + (long)i * POINT;
#pragma unroll
      for (int v = 0; v < WIDTH; ++v) {
        const REALV k = unit_covariance(q[v], x);
        sum[v] = fma(k, (REALV)alpha[i], sum[v]);
#if FACTOR
        STOREV(k, covariances + (long)i * QUERIES + v * VEC);
#endif
      }
    }
#pragma unroll
    for (int v = 0; v < WIDTH; ++v) total[v] += sum[v];
  }
#pragma unroll
  for (int v = 0; v < WIDTH; ++v) STOREV(total[v], means + v * VEC);
}

#if FACTOR
// acc(r, q) += sum_k panel(k, r) rows(k, q), k < depth: PANEL x QUERIES in registers.
#define MULTIPLY_ACCUMULATE(acc, panel, rows, depth)                                     \
  for (int k_ = 0; k_ < (depth); ++k_) {                                                 \
    REALV b_[WIDTH];                                                                     \
    _Pragma("unroll") for (int v_ = 0; v_ < WIDTH; ++v_) {                               \
      b_[v_] = LOADV((rows) + (long)k_ * QUERIES + v_ * VEC);                            \
    }                                                                                    \
    _Pragma("unroll") for (int r_ = 0; r_ < PANEL; ++r_) {                               \
      const REALV a_ = (REALV)((panel)[k_ * PANEL + r_]);                                  \
      _Pragma("unroll") for (int v_ = 0; v_ < WIDTH; ++v_) {                             \
        acc[r_][v_] = fma(a_, b_[v_], acc[r_][v_]);                                      \
      }                                                                                  \
    }                                                                                    \
  }

// target(r, q) += sum_k panel(k, r) rows(k, q).
static inline void add_product(__global const float* panel, __global const float* rows, const int depth,
                        __global float* target) {
  REALV acc[PANEL][WIDTH];
#pragma unroll
  for (int r = 0; r < PANEL; ++r) {
#pragma unroll
    for (int v = 0; v < WIDTH; ++v) acc[r][v] = LOADV(target + r * QUERIES + v * VEC);
  }
  MULTIPLY_ACCUMULATE(acc, panel, rows, depth)
#pragma unroll
  for (int r = 0; r < PANEL; ++r) {
#pragma unroll
    for (int v = 0; v < WIDTH; ++v) STOREV(acc[r][v], target + r * QUERIES + v * VEC);
  }
}

// Rows of the panel := sum_k panel(k, r) rows(k, q), k < depth; the panel's rows are the last PANEL
// of the depth.
static inline void replace_by_product(__global const float* panel, __global float* rows, const int depth) {
  REALV acc[PANEL][WIDTH];
#pragma unroll
  for (int r = 0; r < PANEL; ++r) {
#pragma unroll
    for (int v = 0; v < WIDTH; ++v) acc[r][v] = (REALV)0;
  }
  MULTIPLY_ACCUMULATE(acc, panel, rows, depth)
  __global float* target = rows + (long)(depth - PANEL) * QUERIES;
#pragma unroll
  for (int r = 0; r < PANEL; ++r) {
#pragma unroll
    for (int v = 0; v < WIDTH; ++v) STOREV(acc[r][v], target + r * QUERIES + v * VEC);
  }
}

// Rows [first, first + count) of every micro-tile, count a multiple of PANEL: += (packed part left
// of the diagonal block) times the rows above.
static inline void add_left_part(__global const float* packed, const int first, const int count, const int micro_tiles,
                          __global float* tile, const long micro_stride) {
  for (int k = 0; k < first; k += DEPTH) {
    const int depth = min(DEPTH, first - k);
    for (int t = 0; t < micro_tiles; ++t) {
      __global float* rows = tile + t * micro_stride;
      for (int r = 0; r < count; r += PANEL) {
        add_product(packed + (long)r * depth, rows + (long)k * QUERIES, depth, rows + (long)(first + r) * QUERIES);
      }
    }
    packed += (long)count * depth;
  }
}

// Rows [first, first + count) := packed lower triangle times themselves, from the last panel to the
// first, in place.
static inline void multiply_diagonal_part(__global const float* packed, const int first, const int count,
                                   const int micro_tiles, __global float* tile, const long micro_stride) {
  for (int t = 0; t < micro_tiles; ++t) {
    __global float* rows = tile + t * micro_stride + (long)first * QUERIES;
    for (int r = count - PANEL; r >= 0; r -= PANEL) {
      // Panel p = r / PANEL has PANEL (p + 1) columns, so the panels before it have PANEL^2 p (p +
      // 1) / 2 values.
      replace_by_product(packed + (long)r * (r + PANEL) / 2, rows, r + PANEL);
    }
  }
}

// sums(q) += sum over the rows [first, first + count) of their squares.
static inline void add_squares(const int first, const int count, const int micro_tiles, __global const float* tile,
                        const long micro_stride, __global float* sums) {
  for (int t = 0; t < micro_tiles; ++t) {
    for (int v = 0; v < WIDTH; ++v) {
      __global const float* column = tile + t * micro_stride + (long)first * QUERIES + v * VEC;
      REALV sum = (REALV)0;
      for (int r = 0; r < count; ++r) {
        const REALV value = LOADV(column + (long)r * QUERIES);
        sum = fma(value, value, sum);
      }
      __global float* total = sums + t * QUERIES + v * VEC;
      STOREV(LOADV(total) + sum, total);
    }
  }
}

// Values of the packed factor before the group that starts at row `first`: (first^2 - first GROUP)
// / 2 left of the diagonal blocks, and GROUP (GROUP + PANEL) / 2 in each diagonal block.
static inline long packed_offset(const long first) { return first * (first - GROUP) / 2 + first * (GROUP + PANEL) / 2; }

// Replaces the covariances by L^-1 k* or R k*, and adds their squares to the sums. n is a multiple
// of PANEL.
static inline void apply_factor(__global const float* factor, const int n, const int micro_tiles, __global float* tile,
                         const long micro_stride, __global float* sums) {
#if FACTOR == 1
  for (int first = 0; first < n; first += GROUP) {
    const int count = min(GROUP, n - first);
    __global const float* packed = factor + packed_offset(first);
    add_left_part(packed, first, count, micro_tiles, tile, micro_stride);
    multiply_diagonal_part(packed + (long)first * count, first, count, micro_tiles, tile, micro_stride);
    add_squares(first, count, micro_tiles, tile, micro_stride, sums);
  }
#else
  // From the last group to the first, because the groups below need a group's original rows.
  for (int first = (n - 1) / GROUP * GROUP; first >= 0; first -= GROUP) {
    const int count = min(GROUP, n - first);
    __global const float* packed = factor + packed_offset(first);
    multiply_diagonal_part(packed + (long)first * count, first, count, micro_tiles, tile, micro_stride);
    add_left_part(packed, first, count, micro_tiles, tile, micro_stride);
    add_squares(first, count, micro_tiles, tile, micro_stride, sums);
  }
#endif
}
#endif

// A work-item processes tiles of `micro_tiles` micro-tiles, one after another, until the counter
// next_tile reaches the end. It has its own scratch; the assignment of tiles to work-items does not
// affect the results.
__kernel __attribute__((reqd_work_group_size(WORK_GROUP, 1, 1))) void dense_posterior(
    __global const float* restrict queries, const long query_stride, const long query_count,
    __global const float* restrict inputs, __global const float* restrict alpha, const int input_count, const int padded_count,
    __global const float* restrict factor, const float signal_variance, const float squash_a, const float squash_b,
    const int micro_tiles, const int outputs, __global float* scratch, const long scratch_stride,
    __global volatile int* counters, __global float* restrict mean, __global float* restrict variance,
    __global float* restrict probability,
    const long mean_first, const long variance_first, const long probability_first) {
  mean += mean_first;
  variance += variance_first;
  probability += probability_first;
  const int tile_queries = micro_tiles * QUERIES;
  __global float* tile = scratch + get_global_id(0) * scratch_stride;
#if FACTOR
  const long micro_stride = (long)padded_count * QUERIES;
#else
  const long micro_stride = 0;
#endif
  __global float* means = tile + micro_tiles * micro_stride;
  __global float* sums = means + tile_queries;
  int clamped = 0;
  for (;;) {
    const long first = (long)atomic_inc(counters) * tile_queries;
    if (first >= query_count) break;
    const int count = (int)min((long)tile_queries, query_count - first);
    const int used = (count + QUERIES - 1) / QUERIES;
    for (int t = 0; t < used; ++t) {
      __global float* covariances = tile + t * micro_stride;
      covary(queries + first + t * QUERIES, query_stride, inputs, alpha, input_count, covariances, means + t * QUERIES);
#if FACTOR
      for (long i = (long)input_count * QUERIES; i < micro_stride; ++i) covariances[i] = 0.0f;
#endif
    }
    for (int q = 0; q < used * QUERIES; ++q) sums[q] = 0.0f;
#if FACTOR
    apply_factor(factor, padded_count, used, tile, micro_stride, sums);
#endif
    for (int q = 0; q < count; ++q) {
      clamped += write_posterior(queries, query_stride, first + q, means[q], sums[q], signal_variance, squash_a, squash_b,
                                 outputs, mean, variance, probability);
    }
  }
  if (clamped) atomic_add(counters + 1, clamped);
}
