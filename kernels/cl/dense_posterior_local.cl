// The dense posterior for devices whose work-items run side by side and share local memory (GPUs).
// A work-group processes a tile of queries; scalar work-items hold blocks of it in registers, and
// the operands of products are staged in local memory. Functions are external here, because PoCL
// 3.1 crashes on static ones that contain barriers.
//
// Arguments as in dense_posterior.cl. Macros in addition to common.cl's, whose VEC is 1 and
// POINT_SPACE __local here:
//   PANEL    rows of the factor per work-item
//   PANELS   work-items side by side along rows: GROUP = PANEL PANELS rows are a block
//   WIDTH    queries per work-item
//   COLUMNS  work-items side by side along queries: QUERIES = WIDTH COLUMNS are a tile,
//            PANELS COLUMNS a work-group
//   DEPTH    columns of the factor staged at once, a divisor of GROUP
//   STAGED_POINTS  points staged at once without a factor, a divisor of SUM_BLOCK
//   FACTOR   0 none, 1 Cholesky (blocked substitution), 2 inverse Cholesky (product)
//
// For every block g of GROUP rows, from the first to the last, let K_g be the covariances of its
// rows with the tile's queries, and v_h the results of the earlier blocks in the work-group's
// scratch, padded_count x QUERIES:
//
//   (1) FACTOR 1:  V = K_g - sum_{h<g} L_gh v_h,  v_g = L_gg^-1 V,  squares += v_g^2
//   (2) FACTOR 2:  v_g = K_g,  squares += (sum_{h<=g} R_gh v_h)^2
//
// The factor is packed with panels of GROUP rows (kernels/ops/opencl_posterior_model.h): block g is first_g
// + GROUP columns of GROUP values, with the diagonal block last. Traffic per multiply-add: 4 /
// GROUP bytes of scratch, 4 / QUERIES of the factor, and (PANEL + WIDTH) / (PANEL WIDTH) values of
// local memory. The columns of a tile never mix, and the operations and the order of the sums are
// the same in each: results do not depend on a query's tile.
//
// On an H200 (33.5 T multiply-adds per second in float32, 4.8 TB/s, 132 units of 2,048 work-items,
// 64 k registers and 228 kB of local memory each), with DefaultGpuTuning, n = 4000, D = 6 and every
// pixel of 1242 x 375: groups of 256, 2 per unit, 0.25 of the slots, which is the limit with 128
// registers each (64 sums and two times 8 factors).
//
//   variance    128 queries per tile: 4.0 T multiply-adds, 0.120 s; 0.25 T reads of local memory,
//               of four values each; 126 GB of scratch, 126 GB of factor from cache; measured
//               0.143 s (bench/results/gpu.md)
//   mean alone  1,024 queries per tile: 0.080 T multiply-adds, 0.0024 s; measured 0.008 s, of which
//               most prepares and copies queries
#define GROUP (PANEL * PANELS)
#define QUERIES (WIDTH * COLUMNS)
#define WORK_GROUP (PANELS * COLUMNS)
// Number of queries whose sums a work-item keeps.
#define OWNED ((QUERIES + WORK_GROUP - 1) / WORK_GROUP)

#include "posterior_outputs.cl"

#define LARGER(a, b) ((a) > (b) ? (a) : (b))
#if FACTOR
// Points of a block; columns of the factor and rows of the scratch; sums of squares.
#define STAGE LARGER(GROUP* POINT, LARGER(DEPTH*(GROUP + QUERIES), PANELS * QUERIES))
#else
#define STAGE (STAGED_POINTS * (POINT + 1))
#endif

// stage[0, count) := source[0, count), with zeros from `valid` on; done by the whole work-group.
void fetch(__local float* stage, __global const float* source, const int count, const int valid) {
  for (int i = get_local_id(0); i < count; i += WORK_GROUP) stage[i] = i < valid ? source[i] : 0.0f;
}

void load_query(__global const float* queries, const long query_stride, const long q, float* point) {
  UNROLL for (int c = 0; c < POINT; ++c) point[c] = queries[c * query_stride + q];
}

#if FACTOR
// A work-item's queries, in runs of RUN neighbours: runs are read from local memory at once.
#if WIDTH % 4 == 0 && PANEL % 4 == 0
#define RUN 4
#else
#define RUN 1
#endif
#define QUERY(v) ((v) / RUN * RUN * COLUMNS + column * RUN + (v) % RUN)
// Values of a chunk that a work-item brings to local memory.
#define FETCHED ((DEPTH * (GROUP + QUERIES) + WORK_GROUP - 1) / WORK_GROUP)

// values[0, RUN) := at[0, RUN).
void load_run(__local const float* at, float* values) {
#if RUN == 4
  vstore4(*(__local const float4*)at, 0, values);
#else
  values[0] = at[0];
#endif
}

// A work-item's values of the chunk from column k0 on: of the factor, then of the rows.
void load_chunk(__global const float* packed, __global const float* rows, const int k0, float* next) {
#pragma unroll
  for (int i = 0; i < FETCHED; ++i) {
    const int at = get_local_id(0) + i * WORK_GROUP;
    if (at < DEPTH * GROUP) {
      next[i] = packed[(long)k0 * GROUP + at];
    } else if (at < DEPTH * (GROUP + QUERIES)) {
      next[i] = rows[(long)k0 * QUERIES + at - DEPTH * GROUP];
    }
  }
}

// acc(r, v) += sum_k packed(k, row r) rows(k, query v), k < count, a multiple of DEPTH. A work-item
// skips the chunks from column `zero_from` on, in which its rows of the factor are zero. The next
// chunk is on its way from global memory while one is worked on.
void accumulate(float acc[PANEL][WIDTH], __global const float* packed, __global const float* rows,
                       const int count, const int zero_from, const int panel, const int column,
                       __local float* stage) {
  __local float* staged_rows = stage + DEPTH * GROUP;
  float next[FETCHED];
  if (count > 0) load_chunk(packed, rows, 0, next);
  for (int k0 = 0; k0 < count; k0 += DEPTH) {
    barrier(CLK_LOCAL_MEM_FENCE);
#pragma unroll
    for (int i = 0; i < FETCHED; ++i) {
      const int at = get_local_id(0) + i * WORK_GROUP;
      if (at < DEPTH * (GROUP + QUERIES)) stage[at] = next[i];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (k0 + DEPTH < count) load_chunk(packed, rows, k0 + DEPTH, next);
    if (k0 >= zero_from) continue;
#pragma unroll 4
    for (int k = 0; k < DEPTH; ++k) {
      float a[PANEL], b[WIDTH];
#pragma unroll
      for (int r = 0; r < PANEL; r += RUN) load_run(stage + k * GROUP + panel * PANEL + r, a + r);
#pragma unroll
      for (int v = 0; v < WIDTH; v += RUN) load_run(staged_rows + k * QUERIES + QUERY(v), b + v);
#pragma unroll
      for (int r = 0; r < PANEL; ++r) {
#pragma unroll
        for (int v = 0; v < WIDTH; ++v) acc[r][v] = fma(a[r], b[v], acc[r][v]);
      }
    }
  }
}

void set_zero(float acc[PANEL][WIDTH]) {
#pragma unroll
  for (int r = 0; r < PANEL; ++r) {
#pragma unroll
    for (int v = 0; v < WIDTH; ++v) acc[r][v] = 0.0f;
  }
}

// The work-item's own part of a block in the scratch: visible to the work-group after its next
// barrier of global memory.
void load_block(__global const float* block, const int panel, const int column, float acc[PANEL][WIDTH]) {
#pragma unroll
  for (int r = 0; r < PANEL; ++r) {
#pragma unroll
    for (int v = 0; v < WIDTH; ++v) acc[r][v] = block[(panel * PANEL + r) * QUERIES + QUERY(v)];
  }
}

void store_block(float acc[PANEL][WIDTH], const int panel, const int column, __global float* block) {
#pragma unroll
  for (int r = 0; r < PANEL; ++r) {
#pragma unroll
    for (int v = 0; v < WIDTH; ++v) block[(panel * PANEL + r) * QUERIES + QUERY(v)] = acc[r][v];
  }
}

// block := covariances over sigma_f^2 of its rows with the tile's queries; rows from input_count on
// are zero. The loops are not unrolled, since they would then be most of the program.
void covary_block(__global const float* queries, const long query_stride, const long first_query,
                         __global const float* inputs, const int input_count, const int first,
                         const int panel, const int column, __local float* stage, __global float* block) {
  barrier(CLK_LOCAL_MEM_FENCE);
  fetch(stage, inputs + (long)first * POINT, GROUP * POINT, (input_count - first) * POINT);
  barrier(CLK_LOCAL_MEM_FENCE);
#pragma unroll 1
  for (int v = 0; v < WIDTH; ++v) {
    float query[POINT];
    load_query(queries, query_stride, first_query + QUERY(v), query);
#pragma unroll 1
    for (int row = panel * PANEL; row < (panel + 1) * PANEL; ++row) {
      block[row * QUERIES + QUERY(v)] =
          first + row < input_count ? unit_covariance(query, stage + row * POINT) : 0.0f;
    }
  }
}

// Equations (1) and (2) for one block, and the sums of K_g alpha in the order of the kernel without
// a factor: `partial` is added to `total` after every SUM_BLOCK rows.
void process_block(__global const float* queries, const long query_stride, const long first_query,
                          __global const float* inputs, __global const float* alpha,
                          const int input_count, const int first, __global const float* packed,
                          __global float* rows, const int panel, const int column, float squares[WIDTH],
                          float partial[OWNED], float total[OWNED], __local float* stage) {
  float acc[PANEL][WIDTH];
  __global float* block = rows + (long)first * QUERIES;
  covary_block(queries, query_stride, first_query, inputs, input_count, first, panel, column, stage, block);
  barrier(CLK_GLOBAL_MEM_FENCE);
  const int end = min(GROUP, input_count - first);
  for (int o = 0; o < OWNED; ++o) {
    const int q = get_local_id(0) + o * WORK_GROUP;
    if (q >= QUERIES) break;
    for (int i = 0; i < end; ++i) {
      if ((first + i) % SUM_BLOCK == 0) {
        total[o] += partial[o];
        partial[o] = 0.0f;
      }
      partial[o] = fma(block[i * QUERIES + q], alpha[first + i], partial[o]);
    }
  }
#if FACTOR == 1
  load_block(block, panel, column, acc);
  accumulate(acc, packed, rows, first, first, panel, column, stage);
  barrier(CLK_GLOBAL_MEM_FENCE);
  store_block(acc, panel, column, block);
  barrier(CLK_GLOBAL_MEM_FENCE);
  set_zero(acc);
  accumulate(acc, packed + (long)first * GROUP, block, GROUP, (panel + 1) * PANEL, panel, column, stage);
  barrier(CLK_GLOBAL_MEM_FENCE);
  store_block(acc, panel, column, block);
  barrier(CLK_GLOBAL_MEM_FENCE);
#else
  set_zero(acc);
  accumulate(acc, packed, rows, first + GROUP, first + (panel + 1) * PANEL, panel, column, stage);
#endif
#pragma unroll
  for (int v = 0; v < WIDTH; ++v) {
    float sum = 0.0f;
#pragma unroll
    for (int r = 0; r < PANEL; ++r) sum = fma(acc[r][v], acc[r][v], sum);
    squares[v] += sum;
  }
}

// For one tile: the means go to `total`, the squares of every work-item to the stage.
void process_tile(__global const float* queries, const long query_stride, const long first_query,
                         __global const float* inputs, __global const float* alpha, const int input_count,
                         const int padded_count, __global const float* factor, __global float* rows,
                         float total[OWNED], __local float* stage) {
  const int panel = (int)get_local_id(0) / COLUMNS;
  const int column = (int)get_local_id(0) - panel * COLUMNS;
  float partial[OWNED];
  for (int o = 0; o < OWNED; ++o) {
    partial[o] = 0.0f;
    total[o] = 0.0f;
  }
  float squares[WIDTH];
#pragma unroll
  for (int v = 0; v < WIDTH; ++v) squares[v] = 0.0f;
  for (int first = 0; first < padded_count; first += GROUP) {
    // The earlier blocks have GROUP (GROUP + 2 GROUP + ... + first) values.
    process_block(queries, query_stride, first_query, inputs, alpha, input_count, first,
                  factor + (long)first * (first + GROUP) / 2, rows, panel, column, squares, partial, total, stage);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
#pragma unroll
  for (int v = 0; v < WIDTH; ++v) stage[panel * QUERIES + QUERY(v)] = squares[v];
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int o = 0; o < OWNED; ++o) total[o] += partial[o];
}
#else
// The means of one tile. A work-item owns its queries: COLUMNS is the work-group.
void process_tile(__global const float* queries, const long query_stride, const long first_query,
                         __global const float* inputs, __global const float* alpha, const int input_count,
                         const int padded_count, __global const float* factor, __global float* rows,
                         float total[OWNED], __local float* stage) {
  float query[WIDTH][POINT], sum[WIDTH];
#pragma unroll
  for (int v = 0; v < WIDTH; ++v) {
    load_query(queries, query_stride, first_query + v * COLUMNS + get_local_id(0), query[v]);
    sum[v] = 0.0f;
    total[v] = 0.0f;
  }
  for (int first = 0; first < input_count; first += STAGED_POINTS) {
    const int end = min(STAGED_POINTS, input_count - first);
    barrier(CLK_LOCAL_MEM_FENCE);
    fetch(stage, inputs + (long)first * POINT, end * POINT, end * POINT);
    fetch(stage + STAGED_POINTS * POINT, alpha + first, end, end);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (first % SUM_BLOCK == 0) {
#pragma unroll
      for (int v = 0; v < WIDTH; ++v) {
        total[v] += sum[v];
        sum[v] = 0.0f;
      }
    }
    for (int i = 0; i < end; ++i) {
#pragma unroll
      for (int v = 0; v < WIDTH; ++v) {
        sum[v] = fma(unit_covariance(query[v], stage + i * POINT), stage[STAGED_POINTS * POINT + i], sum[v]);
      }
    }
  }
#pragma unroll
  for (int v = 0; v < WIDTH; ++v) total[v] += sum[v];
}
#endif

// Work-group g processes the tiles g, g + groups, ...; the scratch of each group has
// `scratch_stride` values.
__kernel __attribute__((reqd_work_group_size(WORK_GROUP, 1, 1))) void dense_posterior(
    __global const float* restrict queries, const long query_stride, const long query_count,
    __global const float* restrict inputs, __global const float* restrict alpha, const int input_count,
    const int padded_count, __global const float* restrict factor, const float signal_variance, const float squash_a,
    const float squash_b, const int micro_tiles, const int outputs, __global float* scratch,
    const long scratch_stride, __global volatile int* counters, __global float* restrict mean,
    __global float* restrict variance, __global float* restrict probability,
    const long mean_first, const long variance_first, const long probability_first) {
  __local float stage[STAGE] __attribute__((aligned(16)));
  mean += mean_first;
  variance += variance_first;
  probability += probability_first;
  int clamped = 0;
  for (long first_query = (long)get_group_id(0) * QUERIES; first_query < query_count;
       first_query += (long)get_num_groups(0) * QUERIES) {
    const int count = (int)min((long)QUERIES, query_count - first_query);
    float total[OWNED];
    process_tile(queries, query_stride, first_query, inputs, alpha, input_count, padded_count, factor,
                 scratch + get_group_id(0) * scratch_stride, total, stage);
    for (int o = 0; o < OWNED; ++o) {
      const int q = (int)get_local_id(0) + o * WORK_GROUP;
      if (q >= count) break;
      float sum = 0.0f;
#if FACTOR
      for (int p = 0; p < PANELS; ++p) sum += stage[p * QUERIES + q];
#endif
      clamped += write_posterior(queries, query_stride, first_query + q, total[o], sum, signal_variance, squash_a,
                                 squash_b, outputs, mean, variance, probability);
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  }
  if (clamped) atomic_add(counters + 1, clamped);
}
