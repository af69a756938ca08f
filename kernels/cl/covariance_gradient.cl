// Partial sums of sum_ij W_ij dk_ij / dlog theta / sigma_f^2 over the lower triangle, off-diagonal pairs twice: a
// work-item sums ROWS rows and writes its COMPONENTS + 1 values. `points` holds x prepared, COMPONENTS + 1 values a
// point; `columns` the same transposed, padded to whole vectors. The formulas stand in kernels/reference/covariance.h.
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void covariance_gradient(
    __global const REAL* restrict points, __global const REAL* restrict columns, const long count,
    const long column_stride, __global const REAL* restrict weights, const long weight_stride,
    __global REAL* restrict partial_sums) {
  const long first = (long)get_global_id(0) * ROWS;
  const long last = min(first + ROWS, count);
  REALV sums[COMPONENTS + 1];
#pragma unroll
  for (int c = 0; c <= COMPONENTS; ++c) {
    sums[c] = (REALV)0;
  }
  for (long i = first; i < last; ++i) {
    __global const REAL* x = points + i * (COMPONENTS + 1);
    for (long j = 0; j <= i; j += VEC) {
      REALV z[COMPONENTS + 1];
#pragma unroll
      for (int c = 0; c <= COMPONENTS; ++c) {
        z[c] = LOADV(columns + c * column_stride + j);
      }
      REALV weight;
      if (j + VEC <= i) {
        weight = LOADV(weights + i * weight_stride + j) * (REALV)2;
      } else {
        REAL lanes[VEC];
        for (int lane = 0; lane < VEC; ++lane) {
          const long column = j + lane;
          lanes[lane] = column > i ? (REAL)0 : weights[i * weight_stride + column] * (column == i ? 1 : 2);
        }
        weight = LOADV(lanes);
      }
#if ARCSINE
      const REALV dot = half_vectors_dot(z, x);
      const REALV h = half_of_difference(z, x, dot);
      const REALV sign = with_sign((REALV)1, dot);
      const REALV signed_weight = weight * sign;
      sums[COMPONENTS] = fma(signed_weight * (REALV)2, arccosine_of_half(h), sums[COMPONENTS]);
      // The stored components are halves: 4 (a/2)^2 = a^2.
      const REALV factor = signed_weight * (REALV)2 / sqrt(h * ((REALV)1 - h));
      const REALV twice_h = h * (REALV)2;
#pragma unroll
      for (int c = 0; c < COMPONENTS; ++c) {
        const REALV difference = fma(-sign, (REALV)x[c], z[c]);
        const REALV squares = fma(z[c], z[c], (REALV)(x[c] * x[c]));
        sums[c] = fma(factor, fma(twice_h, squares, -difference * difference), sums[c]);
      }
#else
      const REALV weighted = weight * unit_covariance(z, x);
      sums[COMPONENTS] = fma(weighted, (REALV)2, sums[COMPONENTS]);
#pragma unroll
      for (int c = 0; c < COMPONENTS; ++c) {
        const REALV difference = z[c] - x[c];
        sums[c] = fma(weighted, difference * difference, sums[c]);
      }
#endif
    }
  }
  __global REAL* target = partial_sums + (long)get_global_id(0) * (COMPONENTS + 1);
  for (int c = 0; c <= COMPONENTS; ++c) {
    REAL lanes[VEC];
    STOREV(sums[c], lanes);
    REAL total = lanes[0];
    for (int lane = 1; lane < VEC; ++lane) {
      total += lanes[lane];
    }
    target[c] = total;
  }
}
