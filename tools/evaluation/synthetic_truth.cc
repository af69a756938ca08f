#include "tools/evaluation/synthetic_truth.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/json_fields.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// The drive's folder, for a path with or without masks/ at its end.
fs::path DriveFolder(const std::string& folder) {
  fs::path path = fs::path(folder).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  std::error_code error;
  if (!fs::exists(path / "scene.json", error) && path.filename() == "masks")
    return path.parent_path();
  return path;
}

absl::StatusOr<SyntheticObject> ObjectFromJson(const Json& json) {
  SyntheticObject object;
  JsonFields fields(json, "an object");
  fields.Read("id", object.id);
  fields.Read("class", object.object_class);
  fields.Read("relation", object.relation);
  fields.Read("moving", object.moving);
  fields.Read("distance_metres", object.distance_metres);
  fields.Read("area_pixels", object.area_pixels);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  return object;
}

absl::Status ReadFrames(const Json& frames, SyntheticTruth* truth) {
  for (const Json& frame : frames) {
    int64_t index = 0;
    Json objects;
    JsonFields fields(frame, "a frame");
    fields.Read("index", index);
    fields.Read("objects", objects);
    EGOSIEVE_RETURN_IF_ERROR(fields.status());
    auto& by_id = truth->frames[index];
    for (const Json& entry : objects) {
      EGOSIEVE_ASSIGN_OR_RETURN(SyntheticObject object, ObjectFromJson(entry));
      by_id.emplace(object.id, std::move(object));
    }
  }
  return absl::OkStatus();
}

}  // namespace

bool IsSyntheticTruth(const std::string& folder) {
  std::error_code error;
  return fs::exists(DriveFolder(folder) / "scene.json", error);
}

absl::StatusOr<SyntheticTruth> ReadSyntheticTruth(const std::string& folder) {
  SyntheticTruth truth;
  truth.folder = DriveFolder(folder).string();
  const std::string path = (fs::path(truth.folder) / "scene.json").string();
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded())
    return absl::DataLossError(absl::StrCat(path, " is no JSON; synthesise the drive again"));
  Json frames;
  JsonFields fields(json, path);
  fields.Read("width", truth.width_pixels);
  fields.Read("height", truth.height_pixels);
  fields.Read("frames", frames);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  EGOSIEVE_RETURN_IF_ERROR(ReadFrames(frames, &truth));
  return truth;
}

absl::StatusOr<cv::Mat1i> SyntheticTruth::ReadIds(int64_t frame) const {
  if (frames.count(frame) == 0) {
    return absl::NotFoundError(absl::StrCat(folder, " has no frame ", frame));
  }
  const std::string path = absl::StrFormat("%s/ids/%06d.png", folder, frame);
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat ids, ReadImage(path, cv::IMREAD_UNCHANGED));
  if (ids.type() != CV_16UC1 || ids.cols != width_pixels || ids.rows != height_pixels) {
    return absl::DataLossError(
        absl::StrFormat("%s is no 16-bit grey image of %d x %d pixels; synthesise the drive again",
                        path, width_pixels, height_pixels));
  }
  cv::Mat1i numbers;
  ids.convertTo(numbers, CV_32S);
  return numbers;
}

absl::StatusOr<cv::Mat1i> SyntheticTruth::ReadMovingIds(int64_t frame) const {
  EGOSIEVE_ASSIGN_OR_RETURN(cv::Mat1i ids, ReadIds(frame));
  const std::map<int, SyntheticObject>& objects = frames.at(frame);
  for (int& id : ids) {
    const auto object = objects.find(id);
    if (object == objects.end() || !object->second.moving) id = 0;
  }
  return ids;
}

}  // namespace egosieve::tools
