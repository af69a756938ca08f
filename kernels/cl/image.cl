// Descriptors of image windows and reconstruction from a grid. Needs CHANNELS (1 or 3) beside common.cl's macros.

// The four intensities of a window: sums of 8-bit values over `count` pixels, mapped to [-1, 1]. Both kernels below end
// here, so that they agree bit for bit.
inline void write_descriptor(float u, float v, int blue_sum, int green_sum, int red_sum, int count,
                             __global float* out) {
  const float scale = 2.0f / (255.0f * (float)count);
  const float blue = fma((float)blue_sum, scale, -1.0f);
  const float green = fma((float)green_sum, scale, -1.0f);
  const float red = fma((float)red_sum, scale, -1.0f);
  out[0] = u;
  out[1] = v;
#if CHANNELS == 1
  out[2] = blue;
#else
  out[2] = fma(0.299f, red, fma(0.587f, green, 0.114f * blue));
#endif
  out[3] = red;
  out[4] = green;
  out[5] = blue;
}

// Adds (sign = 1) or subtracts (-1) a row of `size` bytes.
inline void add_row(__global const uchar* row, int size, int sign, __global int* sums) {
  int i = 0;
  for (; i + 16 <= size; i += 16) {
    vstore16(vload16(0, sums + i) + convert_int16(vload16(0, row + i)) * sign, 0, sums + i);
  }
  for (; i < size; ++i) {
    sums[i] += (int)row[i] * sign;
  }
}

// A work-item computes `rows_per_item` rows of the grid. Its two scratch rows hold the sums of each column of bytes over
// the window's rows, which slide from one grid row to the next, and their running sums along the row.
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void descriptor_field(
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
  int bottom = 0;  // the rows [top, bottom) are in sums
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
      write_descriptor(u[column], v[row], end[0] - begin[0], end[CHANNELS / 2] - begin[CHANNELS / 2],
                       end[CHANNELS - 1] - begin[CHANNELS - 1], (right - left) * (bottom - top),
                       out + ((long)row * columns + column) * out_stride);
    }
  }
}

// A work-item describes one point: the window around the pixel (x, y), coordinates u, v of its own. Those behind the
// last point fill its work-group up.
__kernel void descriptors_at(__global const uchar* restrict image, const long stride_bytes, const int width,
                             const int height, const int radius, __global const int2* restrict pixels,
                             __global const float2* restrict coordinates, const long count,
                             __global float* restrict out, const long out_stride) {
  const long i = get_global_id(0);
  if (i >= count) return;
  const int left = max(pixels[i].x - radius, 0);
  const int right = min(pixels[i].x + radius + 1, width);
  const int top = max(pixels[i].y - radius, 0);
  const int bottom = min(pixels[i].y + radius + 1, height);
  int sums[CHANNELS];
  for (int c = 0; c < CHANNELS; ++c) sums[c] = 0;
  for (int y = top; y < bottom; ++y) {
    __global const uchar* row = image + y * stride_bytes;
    for (int x = left; x < right; ++x) {
      for (int c = 0; c < CHANNELS; ++c) sums[c] += row[x * CHANNELS + c];
    }
  }
  write_descriptor(coordinates[i].x, coordinates[i].y, sums[0], sums[CHANNELS / 2], sums[CHANNELS - 1],
                   (right - left) * (bottom - top), out + i * out_stride);
}

// A work-item reconstructs one image row: (1 - f) left + f right, exact where f is 0 or 1.
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void grid_interpolation(
    __global const float* restrict values, const long value_stride, const int columns, const int rows,
    const int stride, const int width, const int height, __global float* restrict out, const long out_stride) {
  const int y = get_global_id(0);
  const int row0 = y / stride;
  const int row1 = min(row0 + 1, rows - 1);
  const int y0 = row0 * stride;
  const int span_y = min(row1 * stride, height - 1) - y0;
  const float fy = span_y > 0 ? (float)(y - y0) / (float)span_y : 0.0f;
  __global const float* upper = values + row0 * value_stride;
  __global const float* lower = values + row1 * value_stride;
  float left = fma(fy, lower[0], (1.0f - fy) * upper[0]);
  __global float* target = out + (long)y * out_stride;
  target[0] = left;
  for (int column = 1; column < columns; ++column) {
    const float right = fma(fy, lower[column], (1.0f - fy) * upper[column]);
    const int x0 = (column - 1) * stride;
    const int x1 = min(column * stride, width - 1);
    for (int x = x0 + 1; x <= x1; ++x) {
      const float f = (float)(x - x0) / (float)(x1 - x0);
      target[x] = fma(f, right, (1.0f - f) * left);
    }
    left = right;
  }
}
