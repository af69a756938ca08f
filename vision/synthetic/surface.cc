#include "vision/synthetic/surface.h"

namespace egosieve::vision {
namespace {

struct Point {
  float x, y, z;  // in the primitive's frame
  float u, v;     // along the face: v upwards on walls
  float footprint;
};

Point FacePoint(const Primitive& primitive, const Hit& hit, float footprint) {
  const Eigen::Vector3f q = hit.local.cast<float>();
  if (primitive.shape == Shape::kCylinder && hit.face == 0) {
    const double angle = std::atan2(hit.local.y(), hit.local.x());
    const auto around = static_cast<float>(angle * primitive.half_size.x());
    return {q.x(), q.y(), q.z(), around, q.z(), footprint};
  }
  const Eigen::Vector3d n = hit.local_normal.cwiseAbs();
  const bool flat = n.z() >= n.x() && n.z() >= n.y();
  const float u = !flat && n.x() >= n.y() ? q.y() : q.x();
  return {q.x(), q.y(), q.z(), u, flat ? q.y() : q.z(), footprint};
}

Color Grainy(const Color& color, const Point& p, uint32_t seed, float coarsest, float contrast) {
  const float noise = FractalNoise(p.u, p.v, seed, p.footprint, {coarsest, 8, 1.02f});
  const float spots = Litter(p.u, p.v, seed + 51, coarsest, 0.7f, p.footprint);
  return color * std::exp(std::clamp(contrast * (0.7f * noise + 2.6f * spots), -1.5f, 0.9f));
}

SurfaceColor House(const Primitive& primitive, const Hit& hit, const Point& p, float texture) {
  const Eigen::Vector3d& h = primitive.half_size;
  const uint32_t seed = primitive.appearance.seed;
  if (hit.face >= 4) return Grainy(Color(0.2f, 0.19f, 0.18f), p, seed, 3.0f, 0.3f);
  const Wall wall = {.house = seed,
                     .wall = Hash(seed, hit.face),
                     .color = primitive.appearance.color,
                     .width = static_cast<float>(2.0 * (hit.face < 2 ? h.y() : h.x())),
                     .height = static_cast<float>(2.0 * h.z()),
                     .texture = texture,
                     .lights_on = primitive.appearance.lights_on};
  return FacadeColor(wall, p.u + 0.5f * wall.width, p.v + 0.5f * wall.height, p.footprint);
}

// Side view of a body: doors, sills, wheel arches, handles.
Color BodySide(const Primitive& primitive, const Point& p, Color paint) {
  const float length = static_cast<float>(primitive.profile->half_size.x());
  const float f = p.footprint;
  float lines = 0.0f;
  for (const float door : {-0.30f, 0.06f, 0.40f}) {
    lines = std::max(lines, SoftLine(0.012f, p.x - door * length, f));
  }
  lines = std::max(lines, 0.6f * SoftLine(0.012f, p.z - 0.15f, f));
  for (const float handle : {-0.02f, 0.34f}) {
    const float along = p.x - handle * length + 0.2f;
    lines = std::max(lines, SoftRectangle(0.0f, 0.14f, along, 0.16f, 0.2f, p.z, f));
  }
  paint *= 1.0f - 0.75f * lines;
  for (const float wheel : {-0.62f, 0.62f}) {
    const float r = std::hypot(p.x - wheel * length, p.z + 0.3f);
    paint *= 1.0f - 0.93f * SoftLine(0.38f, r, f);
  }
  return paint * Mix(0.35f, 1.0f, SoftStep(-0.22f, p.z, 0.08f));
}

// Lamps at the front or the back.
void AddLamps(float lamp, const Color& glass, bool front, bool lights_on, SurfaceColor* out) {
  out->albedo = Blend(out->albedo, glass, lamp);
  if (lights_on)
    out->emission = lamp * (front ? Color(6.0f, 5.6f, 4.8f) : Color(1.6f, 0.05f, 0.03f));
}

SurfaceColor CarBody(const Primitive& primitive, const Hit& hit, const Point& p) {
  const Appearance& look = primitive.appearance;
  const float f = p.footprint;
  const float length = static_cast<float>(primitive.profile->half_size.x());
  Color paint = Grainy(look.color, p, look.seed, 0.9f, 0.13f);
  paint *= 1.0f + 0.5f * Speckles(p.u, p.v, look.seed + 3, 0.35f, 0.3f, f);  // dirt, reflections
  if (std::abs(hit.local_normal.y()) > 0.7) return BodySide(primitive, p, paint);
  if (std::abs(p.x) < length - 0.22f) {  // bonnet and boot lid
    const float seam = std::max(SoftLine(0.012f, std::abs(p.y) - 0.66f, f),
                                SoftLine(0.012f, std::abs(p.x) - 0.55f * length, f));
    return Color(paint * (1.0f - 0.6f * seam));
  }
  const bool front = p.x > 0.0f;
  const float lamp = SoftRectangle(0.5f, 0.84f, std::abs(p.y), 0.0f, 0.2f, p.z, f);
  const float plate = SoftRectangle(-0.26f, 0.26f, p.y, -0.16f, -0.05f, p.z, f);
  const float grille = front ? SoftRectangle(-0.42f, 0.42f, p.y, -0.03f, 0.14f, p.z, f) : 0.0f;
  const float bumper = 1.0f - SoftStep(-0.16f, p.z, f);
  paint = paint * (1.0f - 0.7f * bumper);
  const float slats = 0.5f + 0.5f * SoftStep(0.0f, std::sin(p.z * 120.0f), 240.0f * f);
  paint = Blend(paint, Color(0.1f, 0.1f, 0.1f) * slats, grille);
  const float letters =
      Lettering((p.y + 0.24f) / 0.075f, (p.z + 0.145f) / 0.08f, look.seed + 5, f / 0.08f);
  SurfaceColor out = Blend(paint, Color(0.75f, 0.75f, 0.68f) * (1.0f - 0.85f * letters), plate);
  const Color glass = front ? Color(0.7f, 0.72f, 0.75f) : Color(0.45f, 0.03f, 0.02f);
  AddLamps(lamp, glass, front, look.lights_on, &out);
  return out;
}

Color CarCabin(const Primitive& primitive, const Hit& hit, const Point& p) {
  const Appearance& look = primitive.appearance;
  const float f = p.footprint;
  const float h = static_cast<float>(primitive.profile->half_size.z());
  const float length = static_cast<float>(primitive.profile->half_size.x());
  const Color paint = Grainy(look.color, p, look.seed + 7, 0.9f, 0.13f);
  if (hit.local_normal.z() > 0.8) {  // roof
    return paint * (1.0f - 0.5f * SoftLine(0.02f, std::abs(p.y) - 0.5f, f));
  }
  float glass = SoftBox(-h + 0.07f, h - 0.09f, p.z, f);
  if (std::abs(hit.local_normal.y()) > 0.7) {
    const float slant = (p.z + h) / (2.0f * h);
    glass *= SoftBox(-length + 0.22f + 0.35f * slant, length - 0.2f - 0.62f * slant, p.x, f);
    glass *= SoftStep(0.05f, std::abs(p.x + 0.12f), f);  // the pillar between the doors
  } else {
    glass *= SoftLine(0.62f, p.y, f);
  }
  // Seats, heads and reflections in the glass, fixed to the car.
  const float inside = 0.07f + 0.05f * FractalNoise(p.u, p.v, look.seed + 8, f, {0.7f, 5, 0.75f});
  const float mirrored =
      0.12f * SoftStep(0.0f, p.z - 0.1f + 0.15f * ValueNoise(p.u * 3.0f, look.seed + 9), 0.1f);
  return Blend(paint, Color(0.8f, 0.9f, 1.0f) * std::max(0.02f, inside + mirrored), glass);
}

SurfaceColor Bus(const Primitive& primitive, const Hit& hit, const Point& p) {
  const Appearance& look = primitive.appearance;
  const float f = p.footprint;
  const Eigen::Vector3f h = primitive.half_size.cast<float>();
  SurfaceColor out = Grainy(look.color, p, look.seed, 1.5f, 0.15f);
  if (hit.face >= 4) return out;
  const bool side = hit.face >= 2;
  const float half = side ? h.x() : h.y();
  const float bay = side ? 1.35f : 1.2f;
  const float edge = std::abs(p.u / bay - std::round(p.u / bay)) * bay;
  const float glass = SoftBox(-0.05f, h.z() - 0.35f, p.v, f) * SoftStep(0.06f, edge, f) *
                      SoftLine(half - 0.12f, p.u, f);
  const float people =
      ValueNoise(p.u * 1.6f, look.seed + 4) > 0.1f
          ? 1.0f - SoftStep(0.45f + 0.2f * ValueNoise(p.u * 4.0f, look.seed + 5), p.v, f)
          : 0.0f;
  const float inside = 0.1f + 0.06f * FractalNoise(p.u, p.v, look.seed + 6, f, {1.0f, 6, 0.75f});
  const Color pane = Color(0.8f, 0.9f, 1.0f) * std::max(0.02f, inside * (1.0f - 0.7f * people));
  out.albedo = Blend(out.albedo, pane, glass);
  if (side) {  // an advertisement along the side
    const float board = SoftRectangle(-0.6f * half, 0.6f * half, p.u, -0.85f, -0.2f, p.v, f);
    const float ink =
        Lettering((p.u + 3.0f) / 0.42f, (p.v + 0.8f) / 0.55f, look.seed + 7, f / 0.45f);
    const Color print = Blend(Color(0.75f, 0.7f, 0.3f), Color(0.05f, 0.06f, 0.25f), ink);
    return Blend(out.albedo, print, board);
  }
  const float board = SoftRectangle(-0.8f, 0.8f, p.u, h.z() - 0.33f, h.z() - 0.06f, p.v, f);
  const float ink =
      Lettering((p.u + 0.75f) / 0.2f, (p.v - h.z() + 0.3f) / 0.22f, look.seed + 8, f / 0.22f);
  const Color sign = Color(0.02f, 0.02f, 0.02f) + ink * Color(0.9f, 0.5f, 0.05f);
  out.albedo = Blend(out.albedo, sign, board);
  const float lamp = SoftRectangle(0.7f, 1.05f, std::abs(p.u), -1.05f, -0.85f, p.v, f);
  const bool front = hit.face == 1;
  const Color lens = front ? Color(0.7f, 0.7f, 0.7f) : Color(0.4f, 0.03f, 0.02f);
  AddLamps(lamp, lens, front, look.lights_on, &out);
  return out;
}

Color Wheel(const Primitive& primitive, const Hit& hit, const Point& p) {
  if (hit.face == 0)
    return Grainy(Color(0.03f, 0.03f, 0.032f), p, primitive.appearance.seed, 0.2f, 0.3f);
  const float radius =
      static_cast<float>(std::hypot(hit.local.x(), hit.local.y()) / primitive.half_size.x());
  const float rim = 1.0f - SoftStep(0.66f, radius, 3.0f * p.footprint);
  const float angle = std::atan2(p.y, p.x) * (5.0f / 6.2832f);
  const float spoke = SoftStep(0.22f, std::abs(angle - std::round(angle)), 4.0f * p.footprint);
  const float bright = radius < 0.18f ? 0.35f : 0.45f - 0.33f * spoke;
  return Color(0.035f, 0.035f, 0.038f) + rim * (bright * Color(1.0f, 1.0f, 1.03f));
}

Color Leaves(const Primitive& primitive, const Hit& hit, float footprint) {
  const Eigen::Vector3f q = hit.local.cast<float>();
  const uint32_t seed = primitive.appearance.seed;
  float shade = -0.1f, amplitude = 0.6f;
  float frequency = 1.7f;  // 1/m
  for (uint32_t k = 0; k < 5; ++k) {
    const float fine = Clamp01(1.0f / (1.5f * frequency * footprint) - 1.0f);
    if (!(fine > 0.0f)) break;
    shade += fine * amplitude *
             ValueNoise(q.x() * frequency, q.y() * frequency, q.z() * frequency, seed + k);
    frequency *= 2.1f;
    amplitude *= 0.95f;
  }
  const float yellow = ValueNoise(q.x() * 4.0f, q.y() * 4.0f, q.z() * 4.0f, seed + 9);
  return primitive.appearance.color * Color(1.0f + 0.25f * yellow, 1.0f, 1.0f - 0.2f * yellow) *
         std::exp(std::clamp(1.3f * shade, -2.0f, 1.1f));
}

Color Sign(const Primitive& primitive, const Hit& hit, const Point& p) {
  const Appearance& look = primitive.appearance;
  if (hit.face >= 2) return look.color;
  const float w = static_cast<float>(primitive.half_size.y()),
              h = static_cast<float>(primitive.half_size.z());
  const float border =
      SoftRectangle(-0.85f * w, 0.85f * w, p.u, -0.85f * h, 0.85f * h, p.v, p.footprint);
  const float ink =
      Lettering(2.0f * p.u / w + 4.0f, (p.v / h + 0.6f) / 1.2f, look.seed, 2.0f * p.footprint / w);
  const Color face = Blend(Color(0.8f, 0.8f, 0.78f), look.color, border);
  return Blend(face, Color(0.85f, 0.85f, 0.8f), border * ink);
}

Color Tiles(const Primitive& primitive, const Point& p) {
  const float row = std::floor(p.v / 0.3f), column = std::floor(p.u / 0.25f + 0.5f * row);
  const uint32_t h = Hash(primitive.appearance.seed, column, row);
  const float resolved = Clamp01(0.3f / p.footprint - 1.0f);
  const float fv = p.v / 0.3f - row;
  const float shade = resolved * (0.5f * (Unit(h) - 0.5f) -
                                  0.5f * (1.0f - SoftStep(0.12f, fv, 3.3f * p.footprint)));
  return Grainy(primitive.appearance.color * std::exp(shade), p, primitive.appearance.seed + 3,
                4.0f, 0.28f);
}

}  // namespace

SurfaceColor SurfaceAt(const Primitive& primitive, const Hit& hit, float footprint, float texture) {
  const Appearance& look = primitive.appearance;
  const Point p = FacePoint(primitive, hit, footprint);
  switch (look.material) {
    case Material::kFacade:
      return House(primitive, hit, p, texture);
    case Material::kCarBody:
      return CarBody(primitive, hit, p);
    case Material::kCarCabin:
      return CarCabin(primitive, hit, p);
    case Material::kBus:
      return Bus(primitive, hit, p);
    case Material::kWheel:
      return Wheel(primitive, hit, p);
    case Material::kFoliage:
      return Leaves(primitive, hit, footprint);
    case Material::kSign:
      return Sign(primitive, hit, p);
    case Material::kRoof:
      return Tiles(primitive, p);
    case Material::kPavement:
      if (hit.face != 5) return Grainy(look.color, p, look.seed + 1, 1.0f, 0.3f * texture);
      return PavementAlbedo(look.seed, texture, (hit.local + primitive.origin).head<2>(),
                            footprint);
    case Material::kBark:
      return Grainy(look.color, p, look.seed, 0.3f, 0.6f);
    case Material::kCloth:
      return Grainy(look.color, p, look.seed, 0.35f, 0.4f);
    case Material::kSkin:
      return Grainy(look.color, p, look.seed, 0.12f, 0.25f);
    case Material::kLamp: {
      SurfaceColor lamp = look.color;
      if (look.lights_on) lamp.emission = Color(5.0f, 4.2f, 2.8f);
      return lamp;
    }
    case Material::kMetal:
    case Material::kSpokes:
      break;
  }
  return Grainy(look.color, p, look.seed, 0.6f, 0.25f);
}

}  // namespace egosieve::vision
