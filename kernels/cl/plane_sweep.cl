// Squared differences of patches between two grey pictures (kernels/ops/plane_sweep.h). Needs RADIUS (1 to 3) in addition
// to common.cl's macros. A row of a patch is a float8; its lanes from SIDE on hold numbers that do not count.

#define SIDE (2 * RADIUS + 1)
#define OUTPUTS 6

// `width` bytes a row; 8 bytes beyond the last row may be read.
typedef struct {
  __global const uchar* pixels;
  int width;
  int height;
} Picture;

static inline float sum_of_first(const int count, const float8 lanes) {
  const float8 kept = select((float8)0.0f, lanes, (int8)(0, 1, 2, 3, 4, 5, 6, 7) < (int8)count);
  const float4 four = kept.lo + kept.hi;
  const float2 two = four.lo + four.hi;
  return two.x + two.y;
}

// Levels between neighbouring pixels, all at the distance f from the pixel before.
static inline float8 row_between(__global const uchar* pixels, const float f) {
  const float8 levels = convert_float8(vload8(0, pixels));
  return fma((float8)f, levels.s12345677 - levels, levels);
}

// Levels at the distances f from pixels at `columns`.
static inline float8 scaled_row_between(__global const uchar* row, const int* columns, const float8 f) {
  float before[8], after[8];
#pragma unroll
  for (int i = 0; i < 8; ++i) {
    const uchar2 pair = vload2(0, row + columns[i < SIDE ? i : SIDE - 1]);
    before[i] = pair.x;
    after[i] = pair.y;
  }
  const float8 levels = vload8(0, before);
  return fma(f, vload8(0, after) - levels, levels);
}

// Sums over the rows of a patch of its difference from another, and of the squares.
typedef struct {
  float8 levels;
  float8 squares;
} Sums;

static inline Sums with_row(const Sums sums, const float8 difference) {
  Sums more;
  more.levels = sums.levels + difference;
  more.squares = fma(difference, difference, sums.squares);
  return more;
}

// The square of the difference less its mean.
static inline float square_of(const Sums sums) {
  const float sum = sum_of_first(SIDE, sums.levels);
  return fmax(0.0f, fma(-sum, sum / (float)(SIDE * SIDE), sum_of_first(SIDE, sums.squares)));
}

// |P - S|^2 (SW2), S around (x, y) with pixels `scale` apart; NaN if S leaves the picture.
static inline float squared_difference(const float8* p, const Picture picture, const float x, const float y,
                                       const float scale) {
  const float reach = scale * RADIUS;
  const float left = x - reach, top = y - reach;
  if (!(left >= 0.0f && top >= 0.0f && x + reach < (float)(picture.width - 1) &&
        y + reach < (float)(picture.height - 1))) {
    return NAN;
  }
  Sums sums = {(float8)0.0f, (float8)0.0f};
  if (scale == 1.0f) {
    const int column = (int)left, row = (int)top;
    const float fx = left - (float)column, fy = top - (float)row;
    __global const uchar* pixels = picture.pixels + (long)row * picture.width + column;
    float8 above = row_between(pixels, fx);
#pragma unroll
    for (int v = 0; v < SIDE; ++v) {
      pixels += picture.width;
      const float8 below = row_between(pixels, fx);
      sums = with_row(sums, p[v] - fma((float8)fy, below - above, above));
      above = below;
    }
    return square_of(sums);
  }
  int columns[SIDE];
  float distances[8] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
#pragma unroll
  for (int u = 0; u < SIDE; ++u) {
    // Rounding may lead to the border itself.
    const float at = fma(scale, (float)u, left);
    columns[u] = min((int)at, picture.width - 2);
    distances[u] = at - (float)columns[u];
  }
  const float8 fx = vload8(0, distances);
#pragma unroll
  for (int v = 0; v < SIDE; ++v) {
    const float at = fma(scale, (float)v, top);
    const int row = min((int)at, picture.height - 2);
    __global const uchar* pixels = picture.pixels + (long)row * picture.width;
    const float8 above = scaled_row_between(pixels, columns, fx);
    const float8 below = scaled_row_between(pixels + picture.width, columns, fx);
    sums = with_row(sums, p[v] - fma((float8)(at - (float)row), below - above, above));
  }
  return square_of(sums);
}

// out[3..5]: |P|^2, and trace and smaller eigenvalue of (SW4).
static inline void write_texture(const float8* p, __global float* out) {
  Sums sums = {(float8)0.0f, (float8)0.0f};
#pragma unroll
  for (int v = 0; v < SIDE; ++v) sums = with_row(sums, p[v]);
  float8 xx = (float8)0.0f, yy = (float8)0.0f, xy = (float8)0.0f;
#pragma unroll
  for (int v = 1; v + 1 < SIDE; ++v) {
    const float8 across = p[v].s23456777 - p[v], down = (p[v + 1] - p[v - 1]).s12345677;
    xx = fma(across, across, xx);
    yy = fma(down, down, yy);
    xy = fma(across, down, xy);
  }
  const float scale = 0.25f / (float)((SIDE - 2) * (SIDE - 2));
  const float a = scale * sum_of_first(SIDE - 2, xx), b = scale * sum_of_first(SIDE - 2, yy);
  const float c = scale * sum_of_first(SIDE - 2, xy);
  const float trace = a + b, apart = a - b;
  out[3] = square_of(sums);
  out[4] = trace;
  out[5] = fmax(0.0f, 0.5f * (trace - sqrt(fma(apart, apart, 4.0f * c * c))));
}

// motion: H row by row, then e. steps: w and scale of each of `count`. flow, out: those of the place.
static inline void sweep_place(const Picture first, const Picture second, const int x, const int y,
                               __global const float* motion, __global const float* steps, const int count,
                               __global const float* flow, __global float* out) {
  if (!(x >= RADIUS && y >= RADIUS && x + RADIUS < first.width - 1 && y + RADIUS < first.height - 1)) {
    for (int i = 0; i < OUTPUTS; ++i) out[i] = NAN;
    return;
  }
  float8 p[SIDE];
#pragma unroll
  for (int v = 0; v < SIDE; ++v) {
    p[v] = convert_float8(vload8(0, first.pixels + (long)(y + v - RADIUS) * first.width + x - RADIUS));
  }
  float h[3];
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    h[i] = fma(motion[3 * i], (float)x, fma(motion[3 * i + 1], (float)y, motion[3 * i + 2]));
  }
  float least = INFINITY, best = NAN;
  for (int j = 0; j < count; ++j) {
    const float w = steps[2 * j];
    const float z = fma(w, motion[11], h[2]);
    if (!(z > 0.0f)) continue;
    const float cost = squared_difference(p, second, fma(w, motion[9], h[0]) / z, fma(w, motion[10], h[1]) / z,
                                          steps[2 * j + 1]);
    if (cost < least) {
      least = cost;
      best = (float)j;
    }
  }
  out[0] = isinf(least) ? NAN : least;
  out[1] = best;
  out[2] = squared_difference(p, second, (float)x + flow[0], (float)y + flow[1], 1.0f);
  write_texture(p, out);
}

// For devices with one work-item per core: a work-item computes a row of the grid.
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void plane_sweep(
    __global const uchar* restrict before, __global const uchar* restrict now, const int width, const int height,
    const int stride, const int columns, __global const float* restrict motion, __global const float* restrict steps,
    const int count, __global const float* restrict flow, const long flow_stride, __global float* restrict out,
    const long out_stride) {
  const Picture first = {before, width, height}, second = {now, width, height};
  const int row = get_global_id(0);
  for (int column = 0; column < columns; ++column) {
    const long i = (long)row * columns + column;
    sweep_place(first, second, min(column * stride, width - 1), min(row * stride, height - 1), motion, steps, count,
                flow + i * flow_stride, out + i * out_stride);
  }
}

// A work-item computes one place: (column, row) is its global id. Work-items right of the grid only
// fill the work-groups.
__kernel void plane_sweep_by_place(__global const uchar* restrict before, __global const uchar* restrict now,
                                   const int width, const int height, const int stride, const int columns,
                                   __global const float* restrict motion, __global const float* restrict steps,
                                   const int count, __global const float* restrict flow, const long flow_stride,
                                   __global float* restrict out, const long out_stride) {
  const int column = get_global_id(0), row = get_global_id(1);
  if (column >= columns) return;
  const Picture first = {before, width, height}, second = {now, width, height};
  const long i = (long)row * columns + column;
  sweep_place(first, second, min(column * stride, width - 1), min(row * stride, height - 1), motion, steps, count,
              flow + i * flow_stride, out + i * out_stride);
}
