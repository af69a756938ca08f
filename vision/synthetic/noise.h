// Hash-based noise. Every value is a pure function of its arguments, so that textures are attached
// to surfaces, never repeat, and do not depend on the order of evaluation.
//
//   (NO1) value noise  v(x, y) in [-1, 1]: hashes of the four surrounding integer points, blended
//         with s(t) = t^2 (3 - 2 t)
//   (NO2) fractal      f(x, y) = sum_k p^k m(l_k) v(R^k (x, y) / l_k),  l_k = l_0 / 2^k,
//         R a rotation that keeps the lattices of different octaves apart
//   (NO3) anti-aliasing m(l) = clamp(l / footprint - 1, 0, 1): an octave whose wavelength l a
//         pixel's footprint cannot resolve fades out before it aliases
//
// Reference: Ebert et al., Texturing and Modeling: A Procedural Approach, 3rd ed., chapters 2
// and 6.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace egosieve::vision {

inline uint32_t Hash(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  x ^= x >> 16;
  return x;
}

inline uint32_t Hash(uint32_t seed, int32_t x) {
  return Hash(seed ^ (static_cast<uint32_t>(x) * 0x9e3779b1U));
}

inline uint32_t Hash(uint32_t seed, int32_t x, int32_t y) {
  return Hash(seed ^ (static_cast<uint32_t>(x) * 0x9e3779b1U) ^
              (static_cast<uint32_t>(y) * 0x85ebca77U + 0x165667b1U));
}

// Of the cell with these whole coordinates.
inline uint32_t Hash(uint32_t seed, float x, float y) {
  return Hash(seed, static_cast<int32_t>(x), static_cast<int32_t>(y));
}

// Uniform in [0, 1), from the upper 24 bits.
inline float Unit(uint32_t hash) { return static_cast<float>(hash >> 8) * 0x1p-24f; }

inline float Clamp01(float x) { return std::clamp(x, 0.0f, 1.0f); }

// 0 below `edge`, 1 above it, linear over `width` around it: an edge averaged over a pixel's
// footprint.
inline float SoftStep(float edge, float x, float width) {
  return Clamp01((x - edge) / std::max(width, 1e-6f) + 0.5f);
}

// 1 inside [low, high], 0 outside, softened as above.
inline float SoftBox(float low, float high, float x, float width) {
  return SoftStep(low, x, width) - SoftStep(high, x, width);
}

inline float Mix(float a, float b, float t) { return a + (b - a) * t; }

inline float Signed(uint32_t hash) {  // uniform in [-1, 1)
  return static_cast<float>(static_cast<int32_t>(hash)) * 0x1p-31f;
}

inline float Smooth(float t) { return t * t * (3.0f - 2.0f * t); }

// (NO1) in one, two and three dimensions.
inline float ValueNoise(float x, uint32_t seed) {
  const float floor_x = std::floor(x);
  const int32_t i = static_cast<int32_t>(floor_x);
  return Mix(Signed(Hash(seed, i)), Signed(Hash(seed, i + 1)), Smooth(x - floor_x));
}

inline float ValueNoise(float x, float y, uint32_t seed) {
  const float floor_x = std::floor(x), floor_y = std::floor(y);
  const int32_t i = static_cast<int32_t>(floor_x), j = static_cast<int32_t>(floor_y);
  const float s = Smooth(x - floor_x), t = Smooth(y - floor_y);
  const float below = Mix(Signed(Hash(seed, i, j)), Signed(Hash(seed, i + 1, j)), s);
  const float above = Mix(Signed(Hash(seed, i, j + 1)), Signed(Hash(seed, i + 1, j + 1)), s);
  return Mix(below, above, t);
}

inline float ValueNoise(float x, float y, float z, uint32_t seed) {
  const float floor_z = std::floor(z);
  const int32_t k = static_cast<int32_t>(floor_z);
  return Mix(ValueNoise(x, y, Hash(seed, k)), ValueNoise(x, y, Hash(seed, k + 1)),
             Smooth(z - floor_z));
}

struct FractalBand {
  float coarsest = 1.0f;     // l_0, the longest wavelength, in the units of x and y
  int octaves = 5;           // at most
  float persistence = 0.7f;  // p
};

// (NO2), (NO3). Not normalised: the first octave has amplitude 1.
float FractalNoise(float x, float y, uint32_t seed, float footprint, const FractalBand& band);

}  // namespace egosieve::vision
