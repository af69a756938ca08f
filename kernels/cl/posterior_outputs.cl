// Common end of both kernels of the dense posterior: from the sums of one query to its outputs.

#define WANT_MEAN 1
#define WANT_VARIANCE 2
#define WANT_PROBABILITY 4

// Number of training inputs whose weighted covariances are summed before the sum is added to the
// total: the rounding of a sum of n terms grows as SUM_BLOCK + n / SUM_BLOCK instead of n.
#define SUM_BLOCK 64

static inline float normal_cdf(float x) { return 0.5f * erfc(-x * 0.70710678118654752f); }

// Writes the outputs of query `q`: `value` is its mean (alpha contains sigma_f^2), `squares` is
// |L^-1 k*|^2 / sigma_f^4. Returns 1 if the variance was negative and is clamped, else 0.
static inline int write_posterior(__global const float* queries, const long query_stride, const long q,
                           const float value, const float squares, const float signal_variance, const float squash_a,
                           const float squash_b, const int outputs, __global float* mean,
                           __global float* variance, __global float* probability) {
  if (outputs & WANT_MEAN) mean[q] = value;
  if (!(outputs & (WANT_VARIANCE | WANT_PROBABILITY))) return 0;
  const float prior = unit_variance(queries + q, query_stride);
  // At most one rounding of sigma_f^2 (1 - sigma_f^2 |.|^2) when the two nearly cancel.
  float spread = signal_variance * fma(-signal_variance, squares, prior);
  const int clamped = !(spread >= 0.0f);
  if (clamped) spread = 0.0f;
  if (outputs & WANT_VARIANCE) variance[q] = spread;
  if (outputs & WANT_PROBABILITY) {
    probability[q] = normal_cdf(fma(squash_a, value, squash_b) / sqrt(fma(squash_a * squash_a, spread, 1.0f)));
  }
  return clamped;
}
