#include "tools/colmap/sparse_model.h"

#include <filesystem>
#include <iterator>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/colmap/model_files.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr CameraModel kCameraModels[] = {{"SIMPLE_PINHOLE", 3, 1, LensKind::kPerspective},
                                         {"PINHOLE", 4, 2, LensKind::kPerspective},
                                         {"SIMPLE_RADIAL", 4, 1, LensKind::kPerspective},
                                         {"RADIAL", 5, 1, LensKind::kPerspective},
                                         {"OPENCV", 8, 2, LensKind::kPerspective},
                                         {"OPENCV_FISHEYE", 8, 2, LensKind::kFisheye},
                                         {"FULL_OPENCV", 12, 2, LensKind::kPerspective},
                                         {"FOV", 5, 2, LensKind::kOther},
                                         {"SIMPLE_RADIAL_FISHEYE", 4, 1, LensKind::kFisheye},
                                         {"RADIAL_FISHEYE", 5, 1, LensKind::kFisheye},
                                         {"THIN_PRISM_FISHEYE", 12, 2, LensKind::kOther},
                                         {"RAD_TAN_THIN_PRISM_FISHEYE", 16, 2, LensKind::kOther},
                                         {"SIMPLE_DIVISION", 4, 1, LensKind::kOther},
                                         {"DIVISION", 5, 2, LensKind::kOther},
                                         {"SIMPLE_FISHEYE", 3, 1, LensKind::kFisheye},
                                         {"FISHEYE", 4, 2, LensKind::kFisheye},
                                         {"EUCM", 6, 2, LensKind::kOther},
                                         {"EQUIRECTANGULAR", 2, 0, LensKind::kOther}};

std::string FileIn(const std::string& folder, const char* name, bool is_text) {
  return absl::StrCat(folder, "/", name, is_text ? ".txt" : ".bin");
}

absl::Status CheckReferences(const SparseModel& model) {
  const auto error = [&](const char* file, const auto&... what) {
    return absl::DataLossError(
        absl::StrCat(FileIn(model.folder, file, model.is_text), ": ", what...));
  };
  const auto cameras = PlacesById(model.cameras);
  const auto images = PlacesById(model.images);
  const auto points = PlacesById(model.points);
  if (cameras.size() < model.cameras.size()) return error("cameras", "two cameras have one id");
  if (images.size() < model.images.size()) return error("images", "two images have one id");
  if (points.size() < model.points.size()) return error("points3D", "two points have one id");
  for (const SparseImage& image : model.images) {
    if (cameras.count(image.camera) == 0) {
      return error("images", "the camera ", image.camera, " of image ", image.id, " is missing");
    }
  }
  for (const SparsePoint& point : model.points) {
    for (const TrackElement& element : point.track) {
      const auto image = images.find(element.image);
      if (image == images.end() ||
          element.observation >= model.images[image->second].observations.size()) {
        return error("points3D", "point ", point.id, " has an observation ", element.observation,
                     " of image ", element.image, ", which is missing");
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

const CameraModel* FindCameraModel(int64_t number) {
  return number >= 0 && number < static_cast<int64_t>(std::size(kCameraModels))
             ? &kCameraModels[number]
             : nullptr;
}

absl::StatusOr<SparseModel> ReadSparseModel(const std::string& path, bool with_points) {
  SparseModel model;
  std::error_code error;
  for (const char* below : {"", "/sparse/0", "/sparse", "/0"}) {
    for (const bool is_text : {false, true}) {
      if (model.folder.empty() && fs::exists(FileIn(path + below, "cameras", is_text), error) &&
          fs::exists(FileIn(path + below, "images", is_text), error)) {
        model.folder = path + below;
        model.is_text = is_text;
      }
    }
  }
  if (model.folder.empty()) {
    return absl::NotFoundError(
        absl::StrCat(path,
                     " holds no model of COLMAP: cameras and images, .bin or .txt; name the "
                     "folder that mapper or image_undistorter wrote"));
  }
  const auto read = [&]<typename Item>(const char* name, std::vector<Item>& items) -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(
        items, ParseFile(FileIn(model.folder, name, model.is_text), [&](absl::string_view bytes) {
          return Parse<Item>(bytes, model.is_text);
        }));
    return absl::OkStatus();
  };
  EGOSIEVE_RETURN_IF_ERROR(read("cameras", model.cameras));
  EGOSIEVE_RETURN_IF_ERROR(read("images", model.images));
  if (with_points) EGOSIEVE_RETURN_IF_ERROR(read("points3D", model.points));
  EGOSIEVE_RETURN_IF_ERROR(CheckReferences(model));
  return model;
}

absl::Status WriteSparseModel(const SparseModel& model, const std::string& folder) {
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder));
  const auto write = [&](const char* name, const std::string& bytes) {
    return WriteFileAtomically(FileIn(folder, name, model.is_text), bytes);
  };
  for (const char* name : {"rigs", "frames"}) {
    const std::string path = FileIn(model.folder, name, model.is_text);
    std::error_code error;
    if (!fs::exists(path, error)) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
    EGOSIEVE_RETURN_IF_ERROR(write(name, bytes));
  }
  EGOSIEVE_RETURN_IF_ERROR(write("cameras", Format(model.cameras, model.is_text)));
  EGOSIEVE_RETURN_IF_ERROR(write("images", Format(model.images, model.is_text)));
  return write("points3D", Format(model.points, model.is_text));
}

}  // namespace egosieve::tools
