#include "vision/synthetic/noise.h"

namespace egosieve::vision {
namespace {

inline float Signed(uint32_t hash) {
  return static_cast<float>(static_cast<int32_t>(hash)) * 0x1p-31f;
}

inline float Smooth(float t) { return t * t * (3.0f - 2.0f * t); }

}  // namespace

float ValueNoise(float x, uint32_t seed) {
  const float floor_x = std::floor(x);
  const int32_t i = static_cast<int32_t>(floor_x);
  return Mix(Signed(Hash(seed, i)), Signed(Hash(seed, i + 1)), Smooth(x - floor_x));
}

float ValueNoise(float x, float y, uint32_t seed) {
  const float floor_x = std::floor(x), floor_y = std::floor(y);
  const int32_t i = static_cast<int32_t>(floor_x), j = static_cast<int32_t>(floor_y);
  const float s = Smooth(x - floor_x), t = Smooth(y - floor_y);
  const float below = Mix(Signed(Hash(seed, i, j)), Signed(Hash(seed, i + 1, j)), s);
  const float above = Mix(Signed(Hash(seed, i, j + 1)), Signed(Hash(seed, i + 1, j + 1)), s);
  return Mix(below, above, t);
}

float ValueNoise(float x, float y, float z, uint32_t seed) {
  const float floor_z = std::floor(z);
  const int32_t k = static_cast<int32_t>(floor_z);
  return Mix(ValueNoise(x, y, Hash(seed, k)), ValueNoise(x, y, Hash(seed, k + 1)),
             Smooth(z - floor_z));
}

float FractalNoise(float x, float y, uint32_t seed, float footprint, const FractalBand& band) {
  float sum = 0.0f;
  float amplitude = 1.0f;
  float wavelength = band.coarsest;
  for (int k = 0; k < band.octaves; ++k) {
    const float resolved = Clamp01(wavelength / footprint - 1.0f);  // (N3)
    if (!(resolved > 0.0f)) break;
    const float scale = 1.0f / wavelength;
    sum += amplitude * resolved * ValueNoise(x * scale, y * scale, seed + static_cast<uint32_t>(k));
    const float rotated = 0.8f * x - 0.6f * y;
    y = 0.6f * x + 0.8f * y;
    x = rotated;
    amplitude *= band.persistence;
    wavelength *= 0.5f;
  }
  return sum;
}

}  // namespace egosieve::vision
