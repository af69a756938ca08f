// Prepares points in the order of the caller's matrix (kernels/base/prepared_points.h) in float64:
// value c of p(x_i) goes to out[c component_step + i point_step], zeros for i from `count` on.
// Macros in addition to common.cl's: DIMENSION, POINT and SCALES.
__kernel void prepare_points(__global const REAL* restrict points, const long first, const long stride, const long count,
                             const long padded_count, __global const double* restrict scales_and_centre,
                             __global REAL* restrict out, const long component_step, const long point_step) {
  const long i = get_global_id(0);
  if (i >= padded_count) return;
  double point[POINT];
  for (int c = 0; c < POINT; ++c) point[c] = 0.0;
  if (i < count) {
    double scales[SCALES + 1], centre[DIMENSION], x[DIMENSION];
    for (int t = 0; t < SCALES; ++t) scales[t] = scales_and_centre[t];
    for (int d = 0; d < DIMENSION; ++d) {
      centre[d] = scales_and_centre[SCALES + d];
      x[d] = points[first + i * stride + d];
    }
    prepare_point(scales, x, centre, point);
  }
  for (int c = 0; c < POINT; ++c) out[c * component_step + i * point_step] = point[c];
}
