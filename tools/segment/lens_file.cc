#include "tools/segment/lens_file.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/types/span.h"
#include "kernels/base/status_macros.h"
#include "tools/colmap/lens.h"
#include "tools/colmap/model_files.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {
namespace {

constexpr double kMostSide = 65535;       // pixels
constexpr double kMostShapeError = 0.01;  // of the ratio of sides

// The coefficients of Lens, by name.
absl::Span<const char* const> CoefficientsOf(bool is_fisheye) {
  static constexpr const char* kPerspective[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  static constexpr const char* kFisheye[] = {"k1", "k2", "k3", "k4"};
  return is_fisheye ? absl::Span<const char* const>(kFisheye) : kPerspective;
}

bool IsFinite(const vision::Lens& lens) {
  bool holds = std::isfinite(lens.cx) && std::isfinite(lens.cy);
  for (const double coefficient : lens.distortion) holds = holds && std::isfinite(coefficient);
  for (const double focal : {lens.fx, lens.fy}) holds = holds && focal > 0.0 && focal < 1e9;
  return holds;
}

// Checks the values. width, height: of the pictures.
absl::StatusOr<LensFile> Checked(const vision::Lens& lens, double width, double height) {
  if (!(width >= 1.0 && width <= kMostSide && height >= 1.0 && height <= kMostSide)) {
    return absl::DataLossError(
        absl::StrFormat("the camera's pictures are %g x %g pixels", width, height));
  }
  if (!IsFinite(lens)) {
    return absl::DataLossError(
        absl::StrFormat("the camera's focal lengths are %g and %g; they must be positive, and all "
                        "coefficients numbers",
                        lens.fx, lens.fy));
  }
  return LensFile{lens, {static_cast<int>(width), static_cast<int>(height)}};
}

// OpenCV's principal point, and coefficients in the order of Lens.
void Set(double cx, double cy, const std::vector<double>& distortion, vision::Lens& lens) {
  lens.cx = cx + 0.5;
  lens.cy = cy + 0.5;
  std::copy_n(distortion.begin(),
              std::min(distortion.size(), CoefficientsOf(lens.is_fisheye).size()),
              lens.distortion.begin());
}

std::vector<double> NumbersOf(const YAML::Node& node) {
  return node ? node.as<std::vector<double>>() : std::vector<double>();
}

absl::StatusOr<LensFile> LensOfRos(const YAML::Node& camera) {
  const auto model = camera["distortion_model"].as<std::string>("plumb_bob");
  const std::vector<double> k = NumbersOf(camera["camera_matrix"]["data"]);
  const std::vector<double> d = NumbersOf(camera["distortion_coefficients"]["data"]);
  if (k.size() != 9) return absl::DataLossError("camera_matrix has no 9 numbers");
  vision::Lens lens;
  lens.is_fisheye = model == "equidistant" || model == "fisheye";
  if (!lens.is_fisheye && model != "plumb_bob" && model != "rational_polynomial") {
    return absl::DataLossError(absl::StrCat("the distortion_model ", model,
                                            " is not known; plumb_bob, rational_polynomial and "
                                            "equidistant are"));
  }
  lens.fx = k[0];
  lens.fy = k[4];
  Set(k[2], k[5], d, lens);
  return Checked(lens, camera["image_width"].as<double>(), camera["image_height"].as<double>());
}

absl::StatusOr<LensFile> LensOfKalibr(const YAML::Node& camera) {
  const auto model = camera["camera_model"].as<std::string>("");
  const auto distortion = camera["distortion_model"].as<std::string>("none");
  const std::vector<double> k = NumbersOf(camera["intrinsics"]);
  const std::vector<double> size = NumbersOf(camera["resolution"]);
  vision::Lens lens;
  lens.is_fisheye = distortion == "equi";
  const bool is_known = lens.is_fisheye || distortion == "radtan" || distortion == "none";
  if (model != "pinhole" || !is_known || k.size() != 4 || size.size() != 2) {
    return absl::DataLossError(
        absl::StrCat("the camera is ", model, "-", distortion,
                     "; pinhole-none, pinhole-radtan and pinhole-equi with 4 intrinsics and a "
                     "resolution are read"));
  }
  lens.fx = k[0];
  lens.fy = k[1];
  Set(k[2], k[3], NumbersOf(camera["distortion_coeffs"]), lens);
  return Checked(lens, size[0], size[1]);
}

}  // namespace

absl::StatusOr<LensFile> LensOfColmap(absl::string_view text) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<SparseCamera> cameras,
                            Parse<SparseCamera>(text, true));
  if (cameras.empty()) return absl::DataLossError("there is no camera in it");
  const SparseCamera& camera = cameras.front();
  const absl::StatusOr<vision::Lens> lens = LensOf(camera);
  if (!lens.ok()) return absl::DataLossError(lens.status().message());
  return Checked(*lens, static_cast<double>(camera.width), static_cast<double>(camera.height));
}

absl::StatusOr<LensFile> LensOfYaml(absl::string_view text) {
  // OpenCV's files begin with a line that is no YAML.
  if (absl::StartsWith(text, "%YAML:")) text.remove_prefix(std::min(text.find('\n'), text.size()));
  try {
    const YAML::Node file = YAML::Load(std::string(text));
    if (file.IsMap() && file["camera_matrix"]) return LensOfRos(file);
    if (file.IsMap() && file["cam0"]) return LensOfKalibr(file["cam0"]);
  } catch (const YAML::Exception& error) {
    return absl::DataLossError(error.what());
  }
  return absl::DataLossError(
      "there is neither camera_matrix, as of ROS's and OpenCV's calibration, nor cam0, as of "
      "Kalibr");
}

absl::StatusOr<LensFile> LensOfJson(absl::string_view text) {
  const auto json = nlohmann::ordered_json::parse(text.begin(), text.end(), nullptr, false);
  double width = 0.0, height = 0.0;
  vision::Lens lens;
  JsonFields fields(json, "the camera");
  fields.Field("width", width);
  fields.Field("height", height);
  const auto has = [&](const char* name) { return json.is_object() && json.contains(name); };
  if (has("fx")) {
    fields.Field("fx", lens.fx);
    fields.Field("fy", lens.fy);
  } else {
    fields.Field("focal_pixels", lens.fx);
    lens.fy = lens.fx;
  }
  double cx = 0.5 * (width - 1.0), cy = 0.5 * (height - 1.0);
  if (has("cx")) fields.Field("cx", cx);
  if (has("cy")) fields.Field("cy", cy);
  if (has("fisheye")) fields.Field("fisheye", lens.is_fisheye);
  std::vector<double> distortion;
  for (const char* name : CoefficientsOf(lens.is_fisheye)) {
    distortion.push_back(0.0);
    if (has(name)) fields.Field(name, distortion.back());
  }
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  Set(cx, cy, distortion, lens);
  return Checked(lens, width, height);
}

absl::Status ScaleTo(cv::Size size, LensFile& file) {
  const double x = static_cast<double>(size.width) / file.size.width;
  const double y = static_cast<double>(size.height) / file.size.height;
  if (std::abs(x / y - 1.0) > kMostShapeError) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "its lens has distortion, or a principal point beside the middle, for pictures of %d x %d, "
        "but the frames are %d x %d, of another shape; give a file for them",
        file.size.width, file.size.height, size.width, size.height));
  }
  file.size = size;
  file.lens.fx *= x;
  file.lens.fy *= y;
  file.lens.cx *= x;
  file.lens.cy *= y;
  return absl::OkStatus();
}

nlohmann::ordered_json JsonOfLens(const LensFile& file) {
  const vision::Lens& lens = file.lens;
  nlohmann::ordered_json json = {{"focal_pixels", 0.5 * (lens.fx + lens.fy)},
                                 {"width", file.size.width},
                                 {"height", file.size.height}};
  if (file.is_pinhole()) return json;
  json.update({{"fx", lens.fx}, {"fy", lens.fy}, {"cx", lens.cx - 0.5}, {"cy", lens.cy - 0.5}});
  if (lens.is_fisheye) json["fisheye"] = true;
  const absl::Span<const char* const> names = CoefficientsOf(lens.is_fisheye);
  for (size_t k = 0; k < names.size(); ++k) json[names[k]] = lens.distortion[k];
  return json;
}

absl::StatusOr<LensFile> ReadLensFile(const std::string& path) {
  if (absl::EndsWith(path, ".txt")) return ParseFile(path, LensOfColmap);
  if (absl::EndsWith(path, ".yaml") || absl::EndsWith(path, ".yml")) {
    return ParseFile(path, LensOfYaml);
  }
  return ParseFile(path, LensOfJson);
}

}  // namespace egosieve::tools
