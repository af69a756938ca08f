#include "vision/synthetic/noise.h"

namespace egosieve::vision {
float FractalNoise(float x, float y, uint32_t seed, float footprint, const FractalBand& band) {
  float sum = 0.0f;
  float amplitude = 1.0f;
  float wavelength = band.coarsest;
  for (int k = 0; k < band.octaves; ++k) {
    const float resolved = Clamp01(wavelength / footprint - 1.0f);  // (NO3)
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
