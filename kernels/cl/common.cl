// Common part of every program. Build-time macros:
//   REAL         float or double (REAL_IS_DOUBLE set for double)
//   VEC          lanes of a vector: 1, 4, 8 or 16
//   POINT_SPACE  address space of the single point of a covariance: __global unless set
//
// In programs with a covariance its code follows (kernels/covariance/covariance_function.h): the
// functions unit_covariance, add_gradient and unit_variance, and the macros POINT, the number of
// values of a prepared point, and SCALES.

#ifndef POINT_SPACE
#define POINT_SPACE __global
#endif

#ifdef REAL_IS_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double REAL;
#define BITS long
#define REAL_SIGN 0x8000000000000000L
#else
typedef float REAL;
#define BITS int
#define REAL_SIGN 0x80000000
#endif

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#ifdef REAL_IS_DOUBLE
#define REAL_NAME double
#else
#define REAL_NAME float
#endif

#if VEC == 1
typedef REAL REALV;
typedef BITS BITSV;
#define LOADV(pointer) (*(pointer))
#define STOREV(value, pointer) (*(pointer) = (value))
#define AS_BITSV JOIN(as_, BITS)
#define AS_REALV JOIN(as_, REAL_NAME)
#else
typedef JOIN(REAL_NAME, VEC) REALV;
typedef JOIN(BITS, VEC) BITSV;
#define LOADV(pointer) JOIN(vload, VEC)(0, pointer)
#define STOREV(value, pointer) JOIN(vstore, VEC)(value, 0, pointer)
#define AS_BITSV JOIN(JOIN(as_, BITS), VEC)
#define AS_REALV JOIN(JOIN(as_, REAL_NAME), VEC)
#endif

// `magnitude` with the sign of x.
static inline REALV with_sign(REALV magnitude, REALV x) {
  return AS_REALV(AS_BITSV(magnitude) ^ (AS_BITSV(x) & (BITS)REAL_SIGN));
}

#if !defined(REAL_IS_DOUBLE) && VEC == 16 && defined(__AVX512F__)
#define HAS_AVX512_FLOAT16
typedef float X86_FLOAT16 __attribute__((__vector_size__(64)));
#endif

// pi/2 - 2 asin sqrt(h), 0 <= h <= 1/2: sqrt(h) times a polynomial in h, the interpolant of -2
// asin(sqrt h) / sqrt h at Chebyshev's nodes of [0, 1/2]; absolute error 3e-8 (float), 4e-17
// (double).
#ifdef REAL_IS_DOUBLE
static inline REALV arccosine_of_half(REALV h) {
  REALV p = (REALV)-1.7785808735277375;
  p = fma(p, h, (REALV)6.5578663134796242);
  p = fma(p, h, (REALV)-11.515881662629397);
  p = fma(p, h, (REALV)12.458599750795971);
  p = fma(p, h, (REALV)-9.2841378199776869);
  p = fma(p, h, (REALV)4.9817616252452233);
  p = fma(p, h, (REALV)-2.0164033301068374);
  p = fma(p, h, (REALV)0.59374108613796484);
  p = fma(p, h, (REALV)-0.15743222714004254);
  p = fma(p, h, (REALV)0.005203075696599376);
  p = fma(p, h, (REALV)-0.026382005143507806);
  p = fma(p, h, (REALV)-0.027606891791783959);
  p = fma(p, h, (REALV)-0.034728562878207053);
  p = fma(p, h, (REALV)-0.044743169558640709);
  p = fma(p, h, (REALV)-0.060763926793503654);
  p = fma(p, h, (REALV)-0.089285713525230001);
  p = fma(p, h, (REALV)-0.15000000000803632);
  p = fma(p, h, (REALV)-0.33333333333329973);
  p = fma(p, h, (REALV)-2.0);
  return fma(sqrt(h), p, (REALV)1.57079632679489661923);
}
#else
static inline REALV arccosine_of_half(REALV h) {
  // Half of the polynomial, because twice the root is cheaper to compute.
  REALV p = (REALV)-0.10967398323879114f;
  p = fma(p, h, (REALV)0.09008621671077404f);
  p = fma(p, h, (REALV)-0.07553975382221965f);
  p = fma(p, h, (REALV)-0.016731388950467388f);
  p = fma(p, h, (REALV)-0.046480849462936874f);
  p = fma(p, h, (REALV)-0.07488114441822327f);
  p = fma(p, h, (REALV)-0.16666954671609343f);
  p = fma(p, h, (REALV)-0.9999999887211962f);
#ifdef HAS_AVX512_FLOAT16
  // One Newton step on the 14-bit reciprocal root y: 2 sqrt(h) = (h y) (3 - (h y) y), with a
  // relative error of 2^-23, at a fraction of the cost of the root.
  const X86_FLOAT16 argument = __builtin_astype(h, X86_FLOAT16);
  const REALV y = __builtin_astype(__builtin_ia32_rsqrt14ps512_mask(argument, argument, (ushort)0xffff), REALV);
  const REALV u = h * y;
  const REALV twice_root = u * fma(-u, y, (REALV)3.0f);
#else
  const REALV twice_root = (REALV)2.0f * sqrt(h);
#endif
  return fma(twice_root, p, (REALV)1.57079632679489661923f);
}
#endif

// factor exp(x) for x <= 0: x = n ln 2 + r, |r| <= ln(2) / 2; 0 where exp(x) is below the smallest
// normal number, also for an infinite factor. A sum with 3/2 2^23 (double: 2^52) is rounded to a
// whole number, n, which is in its low bits. `rint` of a vector is slow in PoCL.
#ifdef REAL_IS_DOUBLE
static inline REALV scaled_exp_of_negative(REALV x, REALV factor) {
  const REALV shifted = fma(x, (REALV)1.44269504088896340736, (REALV)6755399441055744.0);
  const REALV n = shifted - (REALV)6755399441055744.0;
  REALV r = fma(n, (REALV)-6.93147180369123816490e-01, x);
  r = fma(n, (REALV)-1.90821492927058770002e-10, r);
  // Taylor polynomial.
  REALV p = (REALV)1.6059043836821613e-10;
  p = fma(p, r, (REALV)2.08767569878681e-09);
  p = fma(p, r, (REALV)2.505210838544172e-08);
  p = fma(p, r, (REALV)2.755731922398589e-07);
  p = fma(p, r, (REALV)2.7557319223985893e-06);
  p = fma(p, r, (REALV)2.48015873015873e-05);
  p = fma(p, r, (REALV)1.984126984126984e-04);
  p = fma(p, r, (REALV)1.388888888888889e-03);
  p = fma(p, r, (REALV)8.333333333333333e-03);
  p = fma(p, r, (REALV)4.1666666666666664e-02);
  p = fma(p, r, (REALV)1.6666666666666666e-01);
  p = fma(p, r, (REALV)0.5);
  p = fma(p, r, (REALV)1.0);
  p = fma(p, r, (REALV)1.0);
  const REALV result = AS_REALV(AS_BITSV(p) + (AS_BITSV(shifted) << 52));
  return x < (REALV)-708.0 ? (REALV)0.0 : factor * result;
}
#else
static inline REALV scaled_exp_of_negative(REALV x, REALV factor) {
  const REALV shifted = fma(x, (REALV)1.44269504f, (REALV)12582912.0f);
  const REALV n = shifted - (REALV)12582912.0f;
  // One product: the rounding of ln 2 is at most 2.4e-7 of the result, where n = -126.
  const REALV r = fma(n, (REALV)-0.69314718f, x);
  // 1 + r + r^2 q(r), q with the least largest relative error of the result, 3.1e-9.
  REALV p = (REALV)0.001381459878757596f;
  p = fma(p, r, (REALV)0.008368716575205326f);
  p = fma(p, r, (REALV)0.04166838899254799f);
  p = fma(p, r, (REALV)0.1666652113199234f);
  p = fma(p, r, (REALV)0.4999999403953552f);
  p = fma(p, r, (REALV)1.0f);
  p = fma(p, r, (REALV)1.0f);
  const REALV result = AS_REALV(AS_BITSV(p) + (AS_BITSV(shifted) << 23));
  return x < (REALV)-87.0f ? (REALV)0.0f : factor * result;
}
#endif

static inline REALV exp_of_negative(REALV x) { return scaled_exp_of_negative(x, (REALV)1); }

// Whether any lane of h is below the limit.
static inline bool any_below(REALV h, REAL limit) {
#ifdef HAS_AVX512_FLOAT16
  return __builtin_ia32_cmpps512_mask(__builtin_astype(h, X86_FLOAT16), __builtin_astype((REALV)limit, X86_FLOAT16), 17,
                                      (ushort)0xffff, 4) != 0;
#elif VEC == 1
  return h < limit;
#else
  return any(h < (REALV)limit);
#endif
}
