// Means over image windows and reconstruction from a grid. Needs CHANNELS (1 or 3) in addition
// to common.cl's macros.

// The four means of a window: sums of 8-bit values over `count` pixels, mapped to [-1, 1]. All
// kernels of box means use this function, so that they agree bit for bit.
static inline void write_means(float u, float v, int sum0, int sum1, int sum2, int count, __global float* out) {
  const float scale = 2.0f / (255.0f * (float)count);
  const float m0 = fma((float)sum0, scale, -1.0f);
  const float m1 = fma((float)sum1, scale, -1.0f);
  const float m2 = fma((float)sum2, scale, -1.0f);
  out[0] = u;
  out[1] = v;
#if CHANNELS == 1
  out[2] = m0;
#else
  out[2] = fma(0.299f, m2, fma(0.587f, m1, 0.114f * m0));
#endif
  out[3] = m2;
  out[4] = m1;
  out[5] = m0;
}

// Adds (sign = 1) or subtracts (-1) a row of `size` bytes.
static inline void add_row(__global const uchar* row, int size, int sign, __global int* sums) {
  int i = 0;
  for (; i + 16 <= size; i += 16) {
    vstore16(vload16(0, sums + i) + convert_int16(vload16(0, row + i)) * sign, 0, sums + i);
  }
  for (; i < size; ++i) {
    sums[i] += (int)row[i] * sign;
  }
}

// For devices with one work-item per core: a work-item computes `rows_per_item` rows of the grid.
// It has two scratch rows. The first holds the sums of each column of bytes over the window's rows,
// which slide from one grid row to the next; the second holds their running sums along the row.
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void box_means_on_grid(
    __global const uchar* restrict image, const long stride_bytes, const int width, const int height, const int radius,
    __global const int* restrict x_pixels, __global const int* restrict y_pixels, __global const float* restrict u,
    __global const float* restrict v, const int columns, const int rows, const int rows_per_item,
    __global int* restrict scratch, __global float* restrict out, const long out_stride) {
  const int size = width * CHANNELS;
  __global int* sums = scratch + (long)get_global_id(0) * (2 * size + CHANNELS);
  __global int* running = sums + size;
  const int first = (int)get_global_id(0) * rows_per_item;
  const int last = min(first + rows_per_item, rows);
  int top = 0;
  int bottom = 0;  // `sums` contains the rows [top, bottom)
  for (int i = 0; i < size; ++i) sums[i] = 0;
  for (int row = first; row < last; ++row) {
    const int new_top = max(y_pixels[row] - radius, 0);
    const int new_bottom = min(y_pixels[row] + radius + 1, height);
    if (new_top >= bottom || new_top - top >= new_bottom - new_top) {
      for (int i = 0; i < size; ++i) sums[i] = 0;
      top = new_top;
      bottom = new_top;
    }
    for (; bottom < new_bottom; ++bottom) add_row(image + bottom * stride_bytes, size, 1, sums);
    for (; top < new_top; ++top) add_row(image + top * stride_bytes, size, -1, sums);
    int totals[CHANNELS];
    for (int c = 0; c < CHANNELS; ++c) {
      totals[c] = 0;
      running[c] = 0;
    }
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < CHANNELS; ++c) {
        totals[c] += sums[x * CHANNELS + c];
        running[(x + 1) * CHANNELS + c] = totals[c];
      }
    }
    for (int column = 0; column < columns; ++column) {
      const int left = max(x_pixels[column] - radius, 0);
      const int right = min(x_pixels[column] + radius + 1, width);
      __global const int* end = running + right * CHANNELS;
      __global const int* begin = running + left * CHANNELS;
      write_means(u[column], v[row], end[0] - begin[0], end[CHANNELS / 2] - begin[CHANNELS / 2],
                       end[CHANNELS - 1] - begin[CHANNELS - 1], (right - left) * (bottom - top),
                       out + ((long)row * columns + column) * out_stride);
    }
  }
}

// The window around the pixel (x, y), clipped at the border.
static inline void window_means(__global const uchar* restrict image, const long stride_bytes, const int width,
                                const int height, const int radius, const int x, const int y, const float u,
                                const float v, __global float* out) {
  const int left = max(x - radius, 0);
  const int right = min(x + radius + 1, width);
  const int top = max(y - radius, 0);
  const int bottom = min(y + radius + 1, height);
  int sums[CHANNELS];
  for (int c = 0; c < CHANNELS; ++c) sums[c] = 0;
  for (int j = top; j < bottom; ++j) {
    __global const uchar* row = image + j * stride_bytes;
    for (int i = left; i < right; ++i) {
      for (int c = 0; c < CHANNELS; ++c) sums[c] += row[i * CHANNELS + c];
    }
  }
  write_means(u, v, sums[0], sums[CHANNELS / 2], sums[CHANNELS - 1], (right - left) * (bottom - top), out);
}

// A work-item computes one point of the grid: (column, row) is its global id. Work-items right of
// the grid only fill the work-groups.
__kernel void box_means_on_grid_by_point(
    __global const uchar* restrict image, const long stride_bytes, const int width, const int height, const int radius,
    __global const int* restrict x_pixels, __global const int* restrict y_pixels, __global const float* restrict u,
    __global const float* restrict v, const int columns, __global float* restrict out, const long out_stride) {
  const int column = get_global_id(0), row = get_global_id(1);
  if (column >= columns) return;
  window_means(image, stride_bytes, width, height, radius, x_pixels[column], y_pixels[row], u[column], v[row],
                  out + ((long)row * columns + column) * out_stride);
}

// A work-item computes one point: the window around the pixel (x, y), with the point's own
// coordinates u, v. Work-items beyond the last point only fill its work-group.
__kernel void box_means_at(__global const uchar* restrict image, const long stride_bytes, const int width,
                           const int height, const int radius, __global const int2* restrict pixels,
                           __global const float2* restrict coordinates, const long count,
                           __global float* restrict out, const long out_stride) {
  const long i = get_global_id(0);
  if (i >= count) return;
  window_means(image, stride_bytes, width, height, radius, pixels[i].x, pixels[i].y, coordinates[i].x,
                  coordinates[i].y, out + i * out_stride);
}

// The two rows of the grid around an image row, and its relative distance from the first.
typedef struct {
  __global const float* upper;
  __global const float* lower;
  float f;
} RowPair;

static inline RowPair rows_around(__global const float* restrict values, const long value_stride, const int rows,
                                  const int stride, const int height, const int y) {
  const int row0 = y / stride;
  const int row1 = min(row0 + 1, rows - 1);
  const int y0 = row0 * stride;
  const int span = min(row1 * stride, height - 1) - y0;
  RowPair pair;
  pair.upper = values + row0 * value_stride;
  pair.lower = values + row1 * value_stride;
  pair.f = span > 0 ? (float)(y - y0) / (float)span : 0.0f;
  return pair;
}

// (1 - f) upper + f lower, exact for f = 0 and f = 1.
static inline float between_rows(const RowPair pair, const int column) {
  return fma(pair.f, pair.lower[column], (1.0f - pair.f) * pair.upper[column]);
}

// At column x of the image, x0 <= x <= x1: (1 - f) left + f right, exact for f = 0 and f = 1.
static inline float between_columns(const float left, const float right, const int x0, const int x1, const int x) {
  const float f = (float)(x - x0) / (float)(x1 - x0);
  return fma(f, right, (1.0f - f) * left);
}

// A work-item reconstructs one image row.
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void grid_interpolation(
    __global const float* restrict values, const long value_stride, const int columns, const int rows,
    const int stride, const int width, const int height, __global float* restrict out, const long out_stride) {
  const int y = get_global_id(0);
  const RowPair pair = rows_around(values, value_stride, rows, stride, height, y);
  __global float* target = out + (long)y * out_stride;
  float left = between_rows(pair, 0);
  target[0] = left;
  for (int column = 1; column < columns; ++column) {
    const float right = between_rows(pair, column);
    const int x0 = (column - 1) * stride;
    const int x1 = min(column * stride, width - 1);
    for (int x = x0 + 1; x <= x1; ++x) target[x] = between_columns(left, right, x0, x1, x);
    left = right;
  }
}

// A work-item reconstructs one pixel: (x, y) is its global id. Work-items right of the image only
// fill the work-groups.
__kernel void grid_interpolation_by_pixel(__global const float* restrict values, const long value_stride,
                                          const int columns, const int rows, const int stride, const int width,
                                          const int height, __global float* restrict out, const long out_stride) {
  const int x = get_global_id(0), y = get_global_id(1);
  if (x >= width) return;
  const RowPair pair = rows_around(values, value_stride, rows, stride, height, y);
  const int column = (x + stride - 1) / stride;  // right of the pixel, or at it
  float value = between_rows(pair, column);
  if (column > 0) {
    const int x0 = (column - 1) * stride;
    value = between_columns(between_rows(pair, column - 1), value, x0, min(column * stride, width - 1), x);
  }
  out[(long)y * out_stride + x] = value;
}
