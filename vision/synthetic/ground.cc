#include <cmath>

#include "vision/synthetic/surface.h"
#include "vision/synthetic/town.h"

namespace egosieve::vision {
namespace {

// Rectangular repairs of the asphalt, one in some cells: contrast, and dark seams at their edges.
float Repairs(float x, float y, uint32_t seed, float footprint) {
  constexpr float kCell = 4.7f;
  const float cx = std::floor(x / kCell), cy = std::floor(y / kCell);
  const uint32_t h = Hash(seed, cx, cy);
  if (Unit(h) > 0.42f) return 0.0f;
  const float u = x - cx * kCell, v = y - cy * kCell;
  const float x0 = 1.6f * Unit(Hash(h + 1)), x1 = kCell - 1.6f * Unit(Hash(h + 2));
  const float y0 = 2.0f * Unit(Hash(h + 3)), y1 = kCell - 2.0f * Unit(Hash(h + 4));
  const float inside = SoftRectangle(x0, x1, u, y0, y1, v, footprint);
  const float core = SoftRectangle(x0 + 0.05f, x1 - 0.05f, u, y0 + 0.05f, y1 - 0.05f, v, footprint);
  const float shade = 0.5f * (Unit(Hash(h + 5)) - 0.6f);
  return shade * core - 0.5f * (inside - core);
}

float Cracks(float x, float y, uint32_t seed, float footprint) {
  const float bend = 0.6f * ValueNoise(x * 0.9f, y * 0.9f, seed + 3);
  const float ridge = std::abs(ValueNoise(x * 0.33f + bend, y * 0.33f - bend, seed));
  const float width = 0.012f;
  return -0.55f * SoftStep(-width, -ridge, 0.01f + 0.3f * footprint) / (1.0f + 12.0f * footprint);
}

float Manhole(float x, float y, uint32_t seed, float footprint) {
  constexpr float kCell = 13.0f;
  const float cx = std::floor(x / kCell), cy = std::floor(y / kCell);
  const uint32_t h = Hash(seed, cx, cy);
  const float u = x - (cx + 0.2f + 0.6f * Unit(h)) * kCell;
  const float v = y - (cy + 0.2f + 0.6f * Unit(Hash(h + 1))) * kCell;
  if (u * u + v * v > 0.25f) return 0.0f;
  const float r = std::hypot(u, v);
  const float lid = 1.0f - SoftStep(0.32f, r, footprint);
  const float rim = SoftBox(0.32f, 0.4f, r, footprint);
  const float pattern =
      SoftStep(0.0f, std::sin(u * 42.0f) * std::sin(v * 42.0f), 60.0f * footprint);
  return lid * (0.25f * pattern - 0.3f) - 0.6f * rim;
}

// White paint of one street: the share of the point that it covers. across, along: the street;
// to_junction: from the centre of the nearest crossing street.
float Markings(float across, float along, float to_junction, uint32_t seed, float footprint) {
  constexpr float kZebraFrom = 6.6f, kZebraTo = 9.8f;
  const float a = std::abs(across), j = std::abs(to_junction);
  if (j < kZebraTo + 0.5f) {
    const float stripe = across - std::round(across);
    return SoftBox(kZebraFrom, kZebraTo, j, footprint) * SoftLine(0.26f, stripe, footprint);
  }
  const bool right_hand = (across < 0.0f) == (to_junction < 0.0f);
  float paint = 0.0f;
  if (j < 12.0f) {  // the stop line of traffic towards the junction
    if (right_hand && a < kLaneWidth) paint = SoftBox(10.8f, 11.3f, j, footprint);
    return std::max(paint, SoftLine(0.08f, a, footprint));
  }
  const float dash = along - 6.0f * std::floor(along / 6.0f);
  paint = SoftLine(0.07f, a, footprint) * SoftBox(0.5f, 3.6f, dash, footprint);
  const float edge = a - static_cast<float>(kLaneWidth);
  const float bay = along - 5.6f * std::floor(along / 5.6f);
  paint = std::max(paint, SoftLine(0.05f, edge, footprint) * SoftBox(0.4f, 5.2f, bay, footprint));
  if (edge > 0.0f) paint = std::max(paint, SoftLine(0.05f, bay - 2.8f, footprint));
  const float worn = FractalNoise(along, across, seed, footprint, {0.7f, 4, 0.8f});
  return paint * Clamp01(0.85f - 0.5f * std::max(0.0f, worn));
}

}  // namespace

float Speckles(float x, float y, uint32_t seed, float cell, float density, float footprint) {
  const float cx = std::floor(x / cell), cy = std::floor(y / cell);
  const uint32_t h = Hash(seed, cx, cy);
  if (Unit(h) > density) return 0.0f;
  const float radius = cell * (0.17f + 0.15f * Unit(Hash(h + 1)));
  const float u = x - cell * (cx + 0.3f + 0.4f * Unit(Hash(h + 2)));
  const float v = y - cell * (cy + 0.3f + 0.4f * Unit(Hash(h + 3)));
  const float width = 0.7f * footprint + 0.35f * radius;
  const float reach = radius + 0.5f * width;
  if (u * u + v * v > reach * reach) return 0.0f;
  const float t = 2.0f * Unit(Hash(h + 4)) - 1.0f;  // (c, s): a half circle of directions
  const float c = (1.0f - t * t) / (1.0f + t * t), s = 2.0f * t / (1.0f + t * t);
  const float slim = 1.0f + 1.2f * Unit(Hash(h + 5));
  const float across = slim * (c * v - s * u), along = c * u + s * v;
  const float r = std::sqrt(along * along + across * across);
  const float strength = Unit(Hash(h + 6)) - 0.5f;
  return (strength + std::copysign(0.25f, strength)) * (1.0f - SoftStep(radius, r, width));
}

float Litter(float x, float y, uint32_t seed, float coarsest, float density, float footprint) {
  float sum = 0.0f;
  for (uint32_t k = 0; k < 7; ++k) {
    const float fine = Clamp01(0.25f * coarsest / footprint - 1.0f);
    if (!(fine > 0.0f)) break;
    // Rotated and shifted, so that the cells of different sizes do not line up.
    const float turned = 0.8f * x - 0.6f * y;
    y = 0.6f * x + 0.8f * y;
    x = turned;
    sum += std::min(1.0f, std::sqrt(0.3f / coarsest)) * fine *
           Speckles(x, y, seed + 31 * k, coarsest, density, footprint);
    coarsest *= 0.5f;
  }
  return sum;
}

Color GroundAlbedo(const GroundStyle& style, const Eigen::Vector2d& point, float footprint) {
  const float x = static_cast<float>(point.x()), y = static_cast<float>(point.y());
  float shade = 0.0f;
  if (style.texture > 0.0f) {
    const uint32_t s = style.seed;
    shade = 0.22f * FractalNoise(x, y, s, footprint, {3.0f, 9, 1.0f});
    shade += Repairs(x, y, s + 101, footprint) + Cracks(x, y, s + 103, footprint);
    shade += Manhole(x, y, s + 107, footprint);
    shade += 1.7f * Litter(x, y, s + 109, 1.3f, 0.75f, footprint);
  }
  const float grey = 0.2f * std::exp(std::clamp(style.texture * shade, -1.7f, 1.3f));
  Color albedo = Color(1.0f, 0.99f, 0.97f) * grey;
  if (!style.markings) return albedo;
  const auto dx = static_cast<float>(point.x() - NearestMultiple(point.x(), kPitchX));
  const auto dy = static_cast<float>(point.y() - NearestMultiple(point.y(), kPitchY));
  const bool along_x = std::abs(dy) <= kKerb, along_y = std::abs(dx) <= kKerb;
  if (along_x == along_y) return albedo;
  const float across = along_x ? dy : -dx, to_junction = along_x ? dx : dy;
  const float paint = Markings(across, along_x ? x : y, to_junction, style.seed + 127, footprint);
  return Blend(albedo, Color(0.72f, 0.72f, 0.68f), paint);
}

Color PavementAlbedo(uint32_t seed, float texture, const Eigen::Vector2d& point, float footprint) {
  const float x = static_cast<float>(point.x()), y = static_cast<float>(point.y());
  constexpr float kSlab = 0.75f;
  const float cx = std::floor(x / kSlab), cy = std::floor(y / kSlab);
  const uint32_t h = Hash(seed, cx, cy);
  const float u = x - cx * kSlab, v = y - cy * kSlab;
  const float inside =
      SoftRectangle(0.015f, kSlab - 0.015f, u, 0.015f, kSlab - 0.015f, v, footprint);
  float shade = 0.5f * (Unit(h) - 0.5f) * Clamp01(kSlab / (2.0f * footprint) - 1.0f) +
                0.45f * (inside - 1.0f);
  shade += 0.18f * FractalNoise(x, y, seed + 5, footprint, {2.0f, 9, 1.0f});
  shade += 1.7f * Litter(x, y, seed + 9, 0.9f, 0.75f, footprint);
  const float warm = 0.04f * (Unit(Hash(h + 1)) - 0.5f);
  return Color(1.0f + warm, 0.98f, 0.93f - warm) *
         (0.32f * std::exp(std::clamp(texture * shade, -1.5f, 0.9f)));
}

}  // namespace egosieve::vision
