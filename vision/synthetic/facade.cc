#include <cmath>

#include "vision/synthetic/surface.h"

namespace egosieve::vision {
namespace {

Color VividColor(uint32_t h) {
  const float hue = 6.2832f * Unit(h), value = 0.12f + 0.5f * Unit(Hash(h + 1));
  const float saturation = 0.25f + 0.6f * Unit(Hash(h + 2));
  const Color wheel(std::cos(hue), std::cos(hue - 2.0944f), std::cos(hue + 2.0944f));
  return value * (1.0f + saturation * wheel);
}

// The wall itself: bricks or render, stains that run down, dirt above the ground.
Color WallAlbedo(const Wall& wall, float u, float v, float footprint) {
  const bool brick = Unit(Hash(wall.house + 11)) < 0.45f;
  float shade = 0.20f * FractalNoise(u, v * 0.8f, wall.wall, footprint, {3.5f, 9, 1.0f});
  shade += 1.7f * Litter(u, v, wall.wall + 21, 1.6f, 0.7f, footprint);
  if (brick) {
    const float row = std::floor(v / 0.12f);
    const float column = std::floor(u / 0.34f + 0.5f * row);
    const uint32_t h = Hash(wall.wall + 13, column, row);
    const float resolved = Clamp01(0.2f / footprint - 1.0f);
    shade += resolved * 0.55f * (Unit(h) - 0.5f);
    const float fu = u / 0.34f + 0.5f * row - column, fv = v / 0.12f - row;
    const float mortar = 1.0f - SoftBox(0.03f, 0.97f, fu, footprint / 0.34f) *
                                    SoftBox(0.08f, 0.92f, fv, footprint / 0.12f);
    shade += 0.35f * mortar * resolved;
  }
  shade -= 0.4f * Clamp01(0.6f - v + 0.4f * ValueNoise(u * 1.3f, wall.wall + 3));  // splashes
  const float streak = ValueNoise(u * 2.3f, v * 0.12f, wall.wall + 5);
  shade -= 0.5f * std::max(0.0f, streak - 0.25f);
  return wall.color * std::exp(std::clamp(wall.texture * shade, -1.5f, 0.8f));
}

// The view through one window of w x h metres, with its frame.
SurfaceColor WindowColor(const Wall& wall, uint32_t h, float u, float v, float w, float height,
                         float footprint) {
  SurfaceColor out;
  const Color frame =
      Unit(Hash(wall.house + 31)) < 0.6f ? Color(0.75f, 0.74f, 0.7f) : Color(0.12f, 0.1f, 0.09f);
  const float kind = Unit(Hash(h + 1));
  const float border = 0.07f;
  const float bars = Unit(Hash(wall.house + 32));
  float inside = SoftRectangle(border, w - border, u, border, height - border, v, footprint);
  if (bars < 0.7f) inside *= 1.0f - SoftLine(0.035f, u - 0.5f * w, footprint);
  if (bars < 0.4f) inside *= 1.0f - SoftLine(0.03f, v - 0.68f * height, footprint);
  const float reflection =
      0.10f + 0.07f * FractalNoise(u + 9.0f * kind, v, h, footprint, {1.4f, 6, 0.9f});
  Color glass = Color(0.75f, 0.9f, 1.05f) * std::max(0.02f, reflection);
  const float blind = height * (1.0f - 0.85f * Unit(Hash(h + 2)));
  if (kind < 0.30f) {  // a blind, partly drawn
    const float slat = 0.8f + 0.2f * SoftStep(0.0f, std::sin(v * 60.0f), 120.0f * footprint);
    glass = Blend(glass, Color(0.6f, 0.56f, 0.48f) * slat, SoftStep(blind, v, footprint));
  } else if (kind < 0.6f) {  // curtains
    const float open = w * (0.12f + 0.3f * Unit(Hash(h + 3)));
    const float cloth = 1.0f - SoftBox(open, w - open, u, footprint);
    const float folds = 0.75f + 0.25f * ValueNoise(u * 9.0f, h);
    glass = Blend(glass, VividColor(h + 4) * (0.9f * folds), cloth);
  } else if (kind < 0.8f) {  // things on the sill
    const float top = 0.25f + 0.35f * ValueNoise(u * 4.0f, h + 5);
    const float object = 1.0f - SoftStep(top, v, footprint);
    glass = Blend(glass, VividColor(Hash(h, static_cast<int32_t>(u * 4.0f))), object);
  }
  if (wall.lights_on && Unit(Hash(h + 6)) < 0.4f) {
    out.emission = Color(1.0f, 0.72f, 0.4f) * (0.25f + 0.35f * Unit(Hash(h + 7))) * inside *
                   (0.6f + 2.0f * glass.mean());
  }
  out.albedo = Blend(frame, glass, inside);
  return out;
}

SurfaceColor UpperFloor(const Wall& wall, float u, float v, float storey, int floor,
                        float footprint) {
  SurfaceColor out;
  const float bay_width = 2.0f + 1.6f * Unit(Hash(wall.house + 41));
  const float bays = std::max(1.0f, std::floor((wall.width - 0.8f) / bay_width));
  const float bay = wall.width / bays;
  const float column = std::clamp(std::floor(u / bay), 0.0f, bays - 1.0f);
  const uint32_t h = Hash(wall.wall + 43, static_cast<int32_t>(column), floor);
  const float w = bay * (0.42f + 0.16f * Unit(Hash(wall.house + 44)));
  const float height = storey * (0.48f + 0.16f * Unit(Hash(wall.house + 45)));
  const float x = u - column * bay - 0.5f * (bay - w) - 0.12f * (Unit(Hash(h + 8)) - 0.5f);
  const float y = v - 0.27f * storey;
  out.albedo = WallAlbedo(wall, u, v + storey * static_cast<float>(floor), footprint);
  const float sill = SoftRectangle(-0.12f, w + 0.12f, x, -0.14f, 0.0f, y, footprint);
  out.albedo = Blend(out.albedo, Color(0.5f, 0.48f, 0.45f), sill);
  const float shutters = Unit(Hash(wall.house + 46));
  if (shutters < 0.3f && x > -0.5f && x < w + 0.5f) {
    const float panel =
        (SoftBox(-0.45f, -0.05f, x, footprint) + SoftBox(w + 0.05f, w + 0.45f, x, footprint)) *
        SoftBox(0.0f, height, y, footprint);
    const float slat = 0.7f + 0.3f * SoftStep(0.0f, std::sin(y * 45.0f), 90.0f * footprint);
    out.albedo = Blend(out.albedo, VividColor(wall.house + 47) * slat, panel);
  }
  const float inside = SoftRectangle(0.0f, w, x, 0.0f, height, y, footprint);
  if (inside > 0.0f) {
    const SurfaceColor window = WindowColor(wall, h, x, y, w, height, footprint);
    out.albedo = Blend(out.albedo, window.albedo, inside);
    out.emission = window.emission * inside;
  }
  return out;
}

// Goods behind a shop window, cell by cell.
Color ShopWindow(uint32_t h, float u, float v, float footprint) {
  const float cell = 0.28f;
  const float resolved = Clamp01(cell / footprint - 1.0f);
  const float i = std::floor(u / cell), j = std::floor(v / cell);
  const uint32_t g = Hash(h, i, j);
  const float fu = u / cell - i, fv = v / cell - j;
  const float margin = 0.05f + 0.3f * Unit(Hash(g + 1));
  const float item =
      SoftRectangle(margin, 1.0f - margin, fu, 0.0f, 1.0f - margin, fv, footprint / cell);
  const float dark = 0.09f + 0.05f * FractalNoise(u, v, h, footprint, {1.5f, 5, 0.75f});
  const Color base = Color(0.8f, 0.9f, 1.0f) * std::max(0.02f, dark);
  return Blend(base, VividColor(g), item * resolved * (Unit(g) < 0.55f ? 0.85f : 0.0f));
}

SurfaceColor GroundFloor(const Wall& wall, float u, float v, float storey, float footprint) {
  SurfaceColor out;
  const float bay_width = 3.4f + 1.8f * Unit(Hash(wall.house + 51));
  const float bays = std::max(1.0f, std::floor(wall.width / bay_width));
  const float bay = wall.width / bays;
  const int32_t column = static_cast<int32_t>(std::floor(u / bay));
  const uint32_t h = Hash(wall.wall + 53, column);
  const float x = u - bay * static_cast<float>(column);
  out.albedo = WallAlbedo(wall, u, v, footprint);
  const float kind = Unit(h);
  if (kind < 0.5f) {  // shop: window, sign above it
    const float glass = SoftRectangle(0.3f, bay - 0.3f, x, 0.5f, storey - 0.75f, v, footprint);
    out.albedo = Blend(out.albedo, ShopWindow(h + 2, x, v, footprint), glass);
    if (wall.lights_on)
      out.emission = Color(1.0f, 0.9f, 0.7f) * 0.5f * glass * (0.2f + out.albedo.mean());
    const float sign =
        SoftRectangle(0.15f, bay - 0.15f, x, storey - 0.62f, storey - 0.08f, v, footprint);
    if (sign > 0.0f) {
      const float ink =
          Lettering((x - 0.4f) / 0.33f, (v - storey + 0.54f) / 0.38f, h + 3, footprint / 0.35f);
      out.albedo =
          Blend(out.albedo, Blend(VividColor(h + 4), Color(0.85f, 0.83f, 0.75f), ink), sign);
      if (wall.lights_on) out.emission += out.albedo * sign * 0.5f;
    }
  } else if (kind < 0.75f) {  // door and a window
    const float door = SoftRectangle(0.5f, 1.5f, x, 0.0f, 2.2f, v, footprint);
    const float panels =
        SoftStep(0.0f, std::sin((x - 0.5f) * 12.6f) * std::sin(v * 6.0f), 14.0f * footprint);
    out.albedo = Blend(out.albedo, VividColor(h + 5) * (0.6f + 0.4f * panels), door);
    const float w = bay - 2.5f, height = storey - 1.5f;
    const float window = SoftRectangle(2.0f, 2.0f + w, x, 0.8f, 0.8f + height, v, footprint);
    if (window > 0.0f && w > 0.3f) {
      const SurfaceColor c = WindowColor(wall, h + 6, x - 2.0f, v - 0.8f, w, height, footprint);
      out.albedo = Blend(out.albedo, c.albedo, window);
      out.emission = c.emission * window;
    }
  } else {  // wall with posters and graffiti
    const float px = x - 0.5f - Unit(Hash(h + 7)), py = v - 0.9f;
    const float poster = SoftRectangle(0.0f, 0.9f, px, 0.0f, 1.3f, py, footprint);
    const float ink = Lettering(px / 0.16f, py / 0.22f, h + 8, footprint / 0.18f);
    out.albedo = Blend(out.albedo, Blend(VividColor(h + 9), Color(0.1f, 0.1f, 0.12f), ink), poster);
    const float line =
        ValueNoise(u * 1.7f, v * 1.5f, h + 10) + 0.35f * ValueNoise(u * 4.0f, v * 4.0f, h + 11);
    const float spray = SoftLine(0.05f, line, 3.0f * footprint) * SoftBox(0.4f, 2.1f, v, 0.5f) *
                        SoftBox(1.8f, bay - 0.2f, x, 0.4f);
    out.albedo = Blend(out.albedo, VividColor(h + 12), 0.85f * spray);
  }
  return out;
}

}  // namespace

float Lettering(float u, float v, uint32_t seed, float footprint) {
  if (v < 0.0f || v > 1.0f) return 0.0f;
  if (footprint > 0.5f) return 0.35f;
  const float letter = std::floor(u);
  const uint32_t h = Hash(seed, static_cast<int32_t>(letter));
  if (Unit(Hash(seed + 9, static_cast<int32_t>(letter))) < 0.15f) return 0.0f;  // a space
  const float column = std::floor((u - letter) * 4.0f), row = std::floor(v * 5.0f);
  return column != 3.0f && Unit(Hash(h, column, row)) < 0.58f ? 1.0f : 0.0f;
}

SurfaceColor FacadeColor(const Wall& wall, float u, float v, float footprint) {
  const float ground_floor = 3.3f + 0.7f * Unit(Hash(wall.house + 61));
  const float storey = 2.7f + 0.7f * Unit(Hash(wall.house + 62));
  SurfaceColor out;
  if (v < ground_floor) {
    out = GroundFloor(wall, u, v, ground_floor, footprint);
  } else if (v > wall.height - 0.7f) {  // cornice
    out.albedo =
        WallAlbedo(wall, u, v, footprint) *
        (SoftBox(wall.height - 0.5f, wall.height - 0.25f, v, footprint) > 0.5f ? 0.6f : 1.15f);
  } else {
    const float above = v - ground_floor;
    const int floor = static_cast<int>(above / storey);
    if (ground_floor + storey * static_cast<float>(floor + 1) > wall.height - 0.6f) {
      out.albedo = WallAlbedo(wall, u, v, footprint);
    } else {
      out =
          UpperFloor(wall, u, above - storey * static_cast<float>(floor), storey, floor, footprint);
    }
  }
  return out;
}

}  // namespace egosieve::vision
