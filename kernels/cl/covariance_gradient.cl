// Partial sums of sum_ij W_ij dk(x_i, z_j) / dlog theta / sigma_f^2. A work-group of WORK_GROUP
// work-items, side by side along the columns, sums ROWS rows and writes its SCALES + 1 values,
// added in the order of the work-items. `points` contains x prepared, POINT values per point;
// `columns` z transposed, padded to whole vectors. With `lower_only` z is x, W is symmetric, and
// pairs below the diagonal count twice in place of those above. The formulas are in the functions'
// files in kernels/covariance.
__kernel __attribute__((reqd_work_group_size(WORK_GROUP, 1, 1))) void covariance_gradient(
    __global const REAL* restrict points, __global const REAL* restrict columns, const long count,
    const long column_count, const long column_stride, const int lower_only, __global const REAL* restrict weights, const long weight_stride,
    __global REAL* restrict partial_sums) {
  const int item = get_local_id(0);
  const long first = (long)get_group_id(0) * ROWS;
  const long last = min(first + ROWS, count);
  REALV sums[SCALES + 1];
  UNROLL for (int t = 0; t <= SCALES; ++t) sums[t] = (REALV)0;
  for (long i = first; i < last; ++i) {
    __global const REAL* x = points + i * POINT;
    const long end = lower_only ? i + 1 : column_count;
    const REAL below = lower_only ? 2 : 1;
    for (long j = (long)item * VEC; j < end; j += WORK_GROUP * VEC) {
      REALV z[POINT];
      UNROLL for (int c = 0; c < POINT; ++c) {
        z[c] = LOADV(columns + c * column_stride + j);
      }
      REALV weight;
      if (j + VEC <= (lower_only ? i : end)) {
        weight = LOADV(weights + i * weight_stride + j) * (REALV)below;
      } else {
        REAL lanes[VEC];
        for (int lane = 0; lane < VEC; ++lane) {
          const long column = j + lane;
          const REAL times = lower_only && column == i ? 1 : below;
          lanes[lane] = column >= end ? (REAL)0 : weights[i * weight_stride + column] * times;
        }
        weight = LOADV(lanes);
      }
      const REALV k = unit_covariance(z, x);
      sums[SCALES] = fma(weight * (REALV)2, k, sums[SCALES]);
      add_gradient(z, x, k, weight, sums);
    }
  }
  __global REAL* target = partial_sums + (long)get_group_id(0) * (SCALES + 1);
#if WORK_GROUP > 1
  __local REAL shared[WORK_GROUP];
#endif
  for (int t = 0; t <= SCALES; ++t) {
    REAL lanes[VEC];
    STOREV(sums[t], lanes);
    REAL total = lanes[0];
    for (int lane = 1; lane < VEC; ++lane) {
      total += lanes[lane];
    }
#if WORK_GROUP > 1
    barrier(CLK_LOCAL_MEM_FENCE);
    shared[item] = total;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int other = 1; item == 0 && other < WORK_GROUP; ++other) total += shared[other];
    if (item == 0)
#endif
      target[t] = total;
  }
}
