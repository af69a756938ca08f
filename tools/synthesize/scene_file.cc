#include "tools/synthesize/scene_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

using nlohmann::ordered_json;

// Six decimals: micrometres, microdegrees.
double Rounded(double value) { return std::round(value * 1e6) / 1e6; }

ordered_json Vector(const Eigen::Vector3d& v) {
  return {Rounded(v.x()), Rounded(v.y()), Rounded(v.z())};
}

ordered_json DescribeObject(const vision::ObjectState& object) {
  return {
      {"id", object.id},
      {"class", vision::ObjectClassName(object.object_class)},
      {"moving", object.moving},
      {"relation", vision::RelationName(object.relation)},
      {"heading_degrees", Rounded(std::remainder(object.heading_radians, 2 * M_PI) * 180 / M_PI)},
      {"position", Vector(object.position)},
      {"velocity", Vector(object.velocity)},
      {"relative_velocity", Vector(object.relative_velocity)},
      {"distance_metres", Rounded(object.distance_metres)},
      {"area_pixels", object.area_pixels},
      {"box", {object.box.x, object.box.y, object.box.width, object.box.height}}};
}

}  // namespace

ordered_json DescribeScenario(const vision::Scenario& scenario, bool video) {
  const vision::ScenarioOptions& options = scenario.options();
  const vision::Intrinsics& k = scenario.intrinsics();
  return {{"format", 1},
          {"scenario", scenario.name()},
          {"seed", scenario.seed()},
          {"width", options.width_pixels},
          {"height", options.height_pixels},
          {"frames_per_second", options.frames_per_second},
          {"video", video},
          {"intrinsics",
           {{"focal_pixels", k.focal_pixels},
            {"centre_x", k.centre_x},
            {"centre_y", k.centre_y},
            {"radial", k.radial}}},
          {"frames", ordered_json::array()}};
}

ordered_json DescribeFrame(const vision::SyntheticFrame& frame) {
  ordered_json pose = ordered_json::array();
  for (int row = 0; row < 3; ++row) {  // in full precision: geometry is computed from it
    const Eigen::Matrix3d& r = frame.pose.rotation;
    pose.push_back({r(row, 0), r(row, 1), r(row, 2), frame.pose.centre[row]});
  }
  ordered_json objects = ordered_json::array();
  for (const vision::ObjectState& object : frame.objects) objects.push_back(DescribeObject(object));
  return {{"index", frame.index},
          {"seconds", Rounded(frame.seconds)},
          {"world_from_camera", pose},
          {"objects", objects}};
}

std::string CameraText(const vision::Scenario& scenario) {
  const vision::ScenarioOptions& options = scenario.options();
  const ordered_json camera = {{"focal_pixels", scenario.intrinsics().focal_pixels},
                               {"radial", scenario.intrinsics().radial},
                               {"width", options.width_pixels},
                               {"height", options.height_pixels},
                               {"frames_per_second", options.frames_per_second}};
  return camera.dump(2) + "\n";
}

std::string PoseLine(const vision::Pose& pose) {
  std::string line;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      absl::StrAppendFormat(&line, "%s%.17g", line.empty() ? "" : " ",
                            column < 3 ? pose.rotation(row, column) : pose.centre[row]);
    }
  }
  return line + "\n";
}

std::string SceneText(const ordered_json& scene) {
  ordered_json head = scene;
  head.erase("frames");
  std::string text = head.dump();
  text.pop_back();  // the closing brace
  text += ",\n\"frames\":[";
  const char* separator = "\n";
  for (const ordered_json& frame : scene.at("frames")) {
    text += separator + frame.dump();
    separator = ",\n";
  }
  return text + "\n]}\n";
}

}  // namespace egosieve::tools
