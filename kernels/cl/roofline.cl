// Measures the device's multiply-add peak: CHAINS independent chains of vectors in registers.
__kernel void multiply_add(const int steps, const REAL factor, const REAL term, __global REAL* restrict out) {
  REALV chains[CHAINS];
#pragma unroll
  for (int c = 0; c < CHAINS; ++c) chains[c] = (REALV)((REAL)0.1f * c);
  for (int step = 0; step < steps; ++step) {
#pragma unroll
    for (int c = 0; c < CHAINS; ++c) chains[c] = fma(chains[c], (REALV)factor, (REALV)term);
  }
  REALV sum = (REALV)0;
#pragma unroll
  for (int c = 0; c < CHAINS; ++c) sum += chains[c];
  STOREV(sum, out + get_global_id(0) * VEC);
}
