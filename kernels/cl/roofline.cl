// The device's multiply-add peak: CHAINS independent chains of vectors in registers.
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void multiply_add(const int steps, const float factor,
                                                                          const float term,
                                                                          __global float* restrict out) {
  REALV chains[CHAINS];
#pragma unroll
  for (int c = 0; c < CHAINS; ++c) chains[c] = (REALV)(c * 0.1f);
  for (int step = 0; step < steps; ++step) {
#pragma unroll
    for (int c = 0; c < CHAINS; ++c) chains[c] = fma(chains[c], (REALV)factor, (REALV)term);
  }
  REALV sum = (REALV)0;
#pragma unroll
  for (int c = 0; c < CHAINS; ++c) sum += chains[c];
  STOREV(sum, out + get_global_id(0) * VEC);
}
