// C(i, j) = k(x_i, z_j). A work-group of WORK_GROUP work-items, side by side along the columns,
// computes ROWS rows. `columns` contains z prepared and transposed, POINT x column_stride, padded
// to whole vectors; `rows` contains x prepared, POINT values per point. C(0, 0) is out[out_first].
__kernel __attribute__((reqd_work_group_size(WORK_GROUP, 1, 1))) void covariance_block(
    __global const REAL* restrict rows, __global const REAL* restrict columns, const long row_count,
    const long column_count, const long column_stride, const REAL signal_variance, const int lower_only,
    __global REAL* restrict out, const long out_first, const long out_stride) {
  const long first = (long)get_group_id(0) * ROWS;
  const long last = min(first + ROWS, row_count);
  const long end = lower_only ? min(last, column_count) : column_count;
  for (long j = (long)get_local_id(0) * VEC; j < end; j += WORK_GROUP * VEC) {
    REALV z[POINT];
    UNROLL for (int c = 0; c < POINT; ++c) {
      z[c] = LOADV(columns + c * column_stride + j);
    }
    for (long i = first; i < last; ++i) {
      const long row_end = lower_only ? min(i + 1, column_count) : column_count;
      const REALV k = unit_covariance(z, rows + i * POINT) * signal_variance;
      __global REAL* target = out + out_first + i * out_stride + j;
      if (j + VEC <= row_end) {
        STOREV(k, target);
      } else if (j < row_end) {
        REAL lanes[VEC];
        STOREV(k, lanes);
        for (int lane = 0; lane < (int)(row_end - j); ++lane) {
          target[lane] = lanes[lane];
        }
      }
    }
  }
}
