#include "vision/synthetic/street.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "kernels/base/parallel_for.h"
#include "vision/image/bilinear.h"
#include "vision/synthetic/noise.h"
#include "vision/synthetic/own_vehicle.h"
#include "vision/synthetic/ray_caster.h"
#include "vision/synthetic/scene.h"

namespace egosieve::vision {
namespace {

// Turns radiance into an 8-bit picture.
//
//   (SE1) motion blur  mean of the radiance along the pixel's own path while the shutter is open
//   (SE2) lens         each pixel gives 11 % of its light to each of its four neighbours
//   (SE3) exposure     e = gain * radiance; noise of variance read^2 + shot^2 e, pseudo-Gaussian,
//                      a hash of frame, pixel and channel
//   (SE4) response     1 - exp(-e), then the sRGB curve s, then the contrast of a consumer camera,
//                      0.3 s + 0.7 s^2 (3 - 2 s)

constexpr int kCurveEntries = 16384;
constexpr float kCurveEnd = 5.0f;  // 1 - exp(-5) equals white within a grey level

std::vector<float> ResponseCurve() {  // (SE4)
  std::vector<float> curve(kCurveEntries);
  for (int k = 0; k < kCurveEntries; ++k) {
    const double linear = 1.0 - std::exp(-kCurveEnd * k / kCurveEntries);
    const double srgb =
        linear < 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
    const double bent = srgb * srgb * (3.0 - 2.0 * srgb);
    curve[k] = static_cast<float>(255.0 * (0.3 * srgb + 0.7 * bent));
  }
  return curve;
}

// Sum of four bytes, centred and scaled to variance 1: nearly Gaussian up to 3 sigma.
float PseudoGaussian(uint32_t hash) {
  const uint32_t sum = (hash & 255u) + ((hash >> 8) & 255u) + ((hash >> 16) & 255u) + (hash >> 24);
  return (static_cast<float>(sum) - 510.0f) / 147.8f;
}

cv::Vec3f Blurred(const cv::Mat& radiance, const cv::Mat& motion, int x, int y) {  // (SE1)
  const cv::Vec2f path = motion.at<cv::Vec2f>(y, x);
  const float length = std::hypot(path[0], path[1]);
  if (!(length > 0.6f)) return radiance.at<cv::Vec3f>(y, x);
  const int samples = std::min(static_cast<int>(std::ceil(length)) + 1, 9);
  cv::Vec3f sum(0, 0, 0);
  for (int k = 0; k < samples; ++k) {
    const float t = (static_cast<float>(k) + 0.5f) / static_cast<float>(samples) - 0.5f;
    sum += SampleClamped<cv::Vec3f>(radiance, static_cast<float>(x) + t * path[0],
                                    static_cast<float>(y) + t * path[1]);
  }
  return sum * (1.0f / static_cast<float>(samples));
}

template <typename Body>
void ForEachPixel(cv::Size size, int threads, const Body& body) {
  kernels::ParallelFor(size.height, {.threads = threads}, [&](int y) {
    for (int x = 0; x < size.width; ++x) body(x, y);
  });
}

cv::Vec3f Spread(const cv::Mat& light, int x, int y) {  // (SE2)
  constexpr float kSide = 0.11f;  // of the energy, in the pixels above, below, left and right
  const auto at = [&](int row, int column) { return light.at<cv::Vec3f>(row, column); };
  const int up = std::max(y - 1, 0), down = std::min(y + 1, light.rows - 1);
  const int left = std::max(x - 1, 0), right = std::min(x + 1, light.cols - 1);
  return at(y, x) * (1.0f - 4.0f * kSide) +
         (at(up, x) + at(down, x) + at(y, left) + at(y, right)) * kSide;
}

// radiance: CV_32FC3, red, green, blue. motion: CV_32FC2, displacement in pixels while the shutter
// is open; empty: no blur. Returns CV_8UC3 in OpenCV's order (blue, green, red).
cv::Mat Expose(const cv::Mat& radiance, const cv::Mat& motion, const SensorSettings& settings,
               double gain, uint32_t seed, int threads) {
  static const auto* const curve = new std::vector<float>(ResponseCurve());
  cv::Mat moved = radiance;
  if (!motion.empty()) {
    moved = cv::Mat(radiance.size(), CV_32FC3);
    ForEachPixel(radiance.size(), threads, [&](int x, int y) {
      moved.at<cv::Vec3f>(y, x) = Blurred(radiance, motion, x, y);
    });
  }
  cv::Mat image(radiance.size(), CV_8UC3);
  const float read = static_cast<float>(settings.read_noise * settings.read_noise);
  const float shot = static_cast<float>(settings.shot_noise * settings.shot_noise);
  ForEachPixel(radiance.size(), threads, [&](int x, int y) {
    const uint32_t pixel = Hash(seed, x, y);
    const cv::Vec3f light = Spread(moved, x, y);
    for (int c = 0; c < 3; ++c) {
      float e = static_cast<float>(gain) * light[c];
      e += std::sqrt(read + shot * e) *
           PseudoGaussian(Hash(pixel + static_cast<uint32_t>(c)));  // (SE3)
      const float place = std::clamp(e * (kCurveEntries / kCurveEnd), 0.0f, kCurveEntries - 1.0f);
      image.at<cv::Vec3b>(y, x)[2 - c] =
          cv::saturate_cast<uchar>((*curve)[static_cast<size_t>(place)]);
    }
  });
  return image;
}

constexpr double kMovingMetresPerSecond = 0.05;

// The picture before the sensor, and the hit of each pixel's central ray.
struct Canvas {
  std::vector<Sample> samples;
  cv::Mat radiance;  // CV_32FC3

  const Sample& at(int x, int y) const {
    return samples[static_cast<size_t>(y) * radiance.cols + x];
  }
};

bool IsEdge(const Canvas& canvas, int x, int y) {
  const int32_t here = canvas.at(x, y).Surface();
  return (x > 0 && canvas.at(x - 1, y).Surface() != here) ||
         (y > 0 && canvas.at(x, y - 1).Surface() != here) ||
         (x + 1 < canvas.radiance.cols && canvas.at(x + 1, y).Surface() != here) ||
         (y + 1 < canvas.radiance.rows && canvas.at(x, y + 1).Surface() != here);
}

Canvas Paint(const RayCaster& caster, const ScenarioOptions& options) {
  const int width = options.width_pixels, height = options.height_pixels;
  Canvas canvas;
  canvas.samples.resize(static_cast<size_t>(width) * height);
  canvas.radiance.create(height, width, CV_32FC3);
  ForEachPixel({width, height}, options.threads, [&](int x, int y) {
    canvas.samples[static_cast<size_t>(y) * width + x] = caster.Cast(x, y);
  });
  ForEachPixel({width, height}, options.threads, [&](int x, int y) {
    Color color = Color::Zero();
    if (IsEdge(canvas, x, y)) {
      // Bright lamps are clipped; otherwise their edges could not be smoothed.
      for (const auto& offset : kSubpixels) {
        color += 0.25f * caster.Radiance(x + offset[0], y + offset[1]).min(4.0f);
      }
    } else {
      color = caster.RadianceInside(x, y, canvas.at(x, y));
    }
    canvas.radiance.at<cv::Vec3f>(y, x) = {color[0], color[1], color[2]};
  });
  return canvas;
}

Eigen::Vector2d Project(const Intrinsics& k, const Pose& pose, const Eigen::Vector3d& point,
                        bool direction) {
  const Eigen::Vector3d local =
      pose.rotation.transpose() * (direction ? point : (point - pose.centre).eval());
  return k.Project({local.x(), local.y(), std::max(local.z(), 1e-3)});
}

// Displacement of each pixel's own surface, in pixels, while the shutter is open.
cv::Mat ShutterMotion(const Scene& scene, const RayCaster& caster, const Canvas& canvas,
                      double seconds, int threads) {
  const double half = 0.5 * scene.sensor.shutter_seconds;
  const Pose before = scene.camera.At(seconds - half), after = scene.camera.At(seconds + half);
  std::vector<Eigen::Vector3d> shift(scene.objects.size());
  for (size_t k = 0; k < shift.size(); ++k) {
    const Eigen::Vector2d v = scene.objects[k].drive.At(seconds).velocity;
    shift[k] = {half * v.x(), half * v.y(), 0.0};
  }
  cv::Mat motion(canvas.radiance.size(), CV_32FC2);
  ForEachPixel(motion.size(), threads, [&](int x, int y) {
    const double depth = canvas.at(x, y).depth();
    const bool sky = std::isinf(depth);
    const Eigen::Vector3d point = caster.PointAt(x, y, depth);
    const int object = canvas.at(x, y).object;
    const Eigen::Vector3d step = object < 0 ? Eigen::Vector3d::Zero().eval() : shift[object];
    const Eigen::Vector2d path = Project(scene.intrinsics, after, point + step, sky) -
                                 Project(scene.intrinsics, before, point - step, sky);
    motion.at<cv::Vec2f>(y, x) = {static_cast<float>(path.x()), static_cast<float>(path.y())};
  });
  return motion;
}

// Exposure that follows the light of the last half second, like an automatic exposure.
double ExposureGain(const Scene& scene, const RayCaster& caster, double seconds) {
  const double swing =
      scene.sensor.exposure_swing * ValueNoise(static_cast<float>(1.4 * seconds), scene.seed + 43);
  const double exposure = scene.sensor.exposure * std::exp(swing);
  if (scene.light.night) return exposure;
  double clouds = 0.0;
  for (int k = 0; k < 5; ++k)
    clouds += 0.2 * caster.Clouds(scene.camera.At(seconds - 0.1 * k).centre, seconds - 0.1 * k);
  return exposure / (0.5 + 0.5 * clouds);
}

Relation RelationTo(const ObjectState& object, const Pose& camera) {
  if (!object.moving) return Relation::kStanding;
  const Eigen::Vector3d axis = camera.rotation.col(2);
  const Eigen::Vector2d forward = axis.head<2>().normalized();
  const double cosine = forward.dot(object.velocity.head<2>().normalized());
  if (cosine > M_SQRT1_2) return Relation::kAhead;
  return cosine < -M_SQRT1_2 ? Relation::kOncoming : Relation::kCrossing;
}

ObjectState DescribeObject(const Scene& scene, int index, const Pose& pose, double seconds) {
  const SceneObject& object = scene.objects[index];
  const DriveState drive = object.drive.At(seconds);
  ObjectState state;
  state.id = index + 1;
  state.object_class = object.object_class;
  state.moving = drive.speed > kMovingMetresPerSecond;
  state.position << drive.pose.position, object.ground_metres;
  state.heading_radians = drive.pose.heading_radians;
  state.velocity << drive.velocity, 0.0;
  state.relative_velocity =
      pose.rotation.transpose() * (state.velocity - scene.camera.Velocity(seconds));
  state.distance_metres = (state.position - pose.centre).norm();
  state.relation = RelationTo(state, pose);
  return state;
}

void FillTruth(const Scene& scene, const Canvas& canvas, SyntheticFrame* frame) {
  frame->mask = cv::Mat::zeros(canvas.radiance.size(), CV_8UC1);
  frame->ids = cv::Mat::zeros(canvas.radiance.size(), CV_16UC1);
  frame->depth.create(canvas.radiance.size(), CV_64FC1);
  std::map<int, ObjectState> visible;
  for (int y = 0; y < canvas.radiance.rows; ++y) {
    for (int x = 0; x < canvas.radiance.cols; ++x) {
      const int object = canvas.at(x, y).object;
      frame->depth.at<double>(y, x) = canvas.at(x, y).depth();
      if (!frame->own_vehicle.empty() && frame->own_vehicle.at<uint8_t>(y, x) != 0) {
        frame->mask.at<uint8_t>(y, x) = 128;
        continue;
      }
      if (object < 0) continue;
      auto [it, is_new] = visible.try_emplace(object);
      ObjectState& state = it->second;
      if (is_new) {
        state = DescribeObject(scene, object, frame->pose, frame->seconds);
        state.box = cv::Rect(x, y, 1, 1);
      }
      state.box |= cv::Rect(x, y, 1, 1);
      ++state.area_pixels;
      frame->ids.at<uint16_t>(y, x) = static_cast<uint16_t>(state.id);
      if (state.moving) frame->mask.at<uint8_t>(y, x) = 255;
    }
  }
  for (auto& [object, state] : visible) frame->objects.push_back(state);
}

}  // namespace

absl::Status ScenarioOptions::Validate() const {
  const struct {
    const char* name;
    double value, low, high;
  } fields[] = {{"width_pixels", 1.0 * width_pixels, 16, 8192},
                {"height_pixels", 1.0 * height_pixels, 16, 8192},
                {"frames", 1.0 * frames, 1, 100000},
                {"frames_per_second", frames_per_second, 1, 1000},
                {"field_of_view_degrees", field_of_view_degrees, 10, 150},
                {"radial", radial, -0.5, 0.5},
                {"exposure_swing", exposure_swing, 0, 2},
                {"threads", 1.0 * threads, 1, 256}};
  for (const auto& field : fields) {
    if (field.value >= field.low && field.value <= field.high) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s = %g; it must be from %g to %g", field.name, field.value, field.low, field.high));
  }
  return absl::OkStatus();
}

const char* RelationName(Relation relation) {
  static constexpr const char* kNames[] = {"standing", "ahead", "oncoming", "crossing"};
  return kNames[static_cast<int>(relation)];
}

Scenario::Scenario(std::string name, uint64_t seed, const ScenarioOptions& options, Scene scene)
    : name_(std::move(name)),
      seed_(seed),
      options_(options),
      scene_(std::make_shared<Scene>(std::move(scene))),
      index_(std::make_shared<SceneIndex>(*scene_)) {
  if (!scene_->own_vehicle.visible) return;
  own_vehicle_ = std::make_shared<OwnVehicle>(
      scene_->own_vehicle, cv::Size(options.width_pixels, options.height_pixels));
}

Pose Scenario::PoseAt(int frame) const {
  return scene_->camera.At(frame / options_.frames_per_second);
}

absl::StatusOr<SyntheticFrame> Scenario::Render(int frame) const {
  if (frame < 0 || frame >= options_.frames) {
    return absl::OutOfRangeError(absl::StrFormat("frame %d of scenario %s; it has frames 0 to %d",
                                                 frame, name_, options_.frames - 1));
  }
  SyntheticFrame out;
  out.index = frame;
  out.seconds = frame / options_.frames_per_second;
  const RayCaster caster(*scene_, *index_, out.seconds, options_.width_pixels,
                         options_.height_pixels);
  out.pose = caster.pose();
  Canvas canvas = Paint(caster, options_);
  SensorSettings sensor = scene_->sensor;
  if (!options_.noise) sensor.read_noise = sensor.shot_noise = 0.0;
  cv::Mat motion;
  if (options_.motion_blur)
    motion = ShutterMotion(*scene_, caster, canvas, out.seconds, options_.threads);
  if (own_vehicle_ != nullptr) {
    own_vehicle_->Cover(&canvas.radiance);
    out.own_vehicle = own_vehicle_->mask().clone();
    if (!motion.empty()) motion.setTo(cv::Scalar::all(0), out.own_vehicle);
  }
  out.image = Expose(canvas.radiance, motion, sensor, ExposureGain(*scene_, caster, out.seconds),
                     Hash(scene_->seed + 41, frame), options_.threads);
  if (own_vehicle_ != nullptr) own_vehicle_->Stamp(out.seconds, &out.image);
  FillTruth(*scene_, canvas, &out);
  return out;
}

std::vector<std::string> ScenarioNames() {
  std::vector<std::string> names;
  for (const ScenarioDescription& scenario : Scenarios()) names.emplace_back(scenario.name);
  return names;
}

absl::StatusOr<Scenario> MakeScenario(std::string_view name, uint64_t seed,
                                      const ScenarioOptions& options) {
  const absl::Status valid = options.Validate();
  if (!valid.ok()) return valid;
  const auto scenario = std::find_if(Scenarios().begin(), Scenarios().end(),
                                     [&](const auto& each) { return each.name == name; });
  if (scenario == Scenarios().end()) {
    return absl::NotFoundError(absl::StrFormat("no scenario is called \"%s\"; there are: %s",
                                               std::string(name),
                                               absl::StrJoin(ScenarioNames(), ", ")));
  }
  Scene scene = BuildScene(*scenario, seed, options.frames / options.frames_per_second);
  scene.intrinsics.focal_pixels =
      0.5 * options.width_pixels / std::tan(options.field_of_view_degrees * M_PI / 360.0);
  scene.intrinsics.centre_x = 0.5 * (options.width_pixels - 1);
  scene.intrinsics.centre_y = 0.5 * (options.height_pixels - 1);
  scene.intrinsics.radial = options.radial;
  scene.sensor.exposure_swing = options.exposure_swing;
  if (!scene.intrinsics.DistortsUpTo(
          std::hypot(scene.intrinsics.centre_x + 1.0, scene.intrinsics.centre_y + 1.0))) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "radial = %g folds the corners of the picture over at a field of view of %g degrees; take "
        "one nearer to 0 or a smaller field of view",
        options.radial, options.field_of_view_degrees));
  }
  if (scene.objects.size() > 65534) {
    return absl::ResourceExhaustedError(absl::StrFormat(
        "scenario %s with %d frames has %d objects; ids have 16 bits: ask for fewer frames",
        std::string(name), options.frames, scene.objects.size()));
  }
  return Scenario(std::string(name), seed, options, std::move(scene));
}

}  // namespace egosieve::vision
