// COLMAP's sparse model: cameras, images with their observations, and 3-D points with their tracks.
//
// A folder holds it as cameras.bin, images.bin and points3D.bin, or as .txt; of both, COLMAP reads
// the binary ones. COLMAP 3.12 and later add rigs and frames, which are copied and not read. The
// order of all items is kept, so an unchanged model has its bytes again.
//
// Reference: COLMAP's documentation, "Output Format"; src/colmap/scene/reconstruction_io_*.cc and
// src/colmap/sensor/models.h.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::tools {

// How a camera model maps a ray (u, v, 1): by the equations of lens.h, or by others.
enum class LensKind { kOther, kPerspective, kFisheye };

struct CameraModel {
  const char* name;
  int parameters;  // the focal lengths come first, then the principal point
  int focals;
  LensKind lens;
};

// By COLMAP's number of the model; nullptr for numbers that it does not have.
const CameraModel* FindCameraModel(int64_t number);

struct SparseCamera {
  uint32_t id = 0;
  int32_t model = 0;                    // FindCameraModel
  uint64_t width = 0, height = 0;       // pixels
  std::vector<double> parameters = {};  // as many as the model has
};

inline constexpr int64_t kNoPoint = -1;

struct Observation {
  double x = 0.0, y = 0.0;   // pixels; the centre of the upper left one is (0.5, 0.5)
  int64_t point = kNoPoint;  // the id of a SparsePoint
};

struct SparseImage {
  uint32_t id = 0;
  std::array<double, 7> pose = {};  // camera from world: quaternion w, x, y, z; translation
  uint32_t camera = 0;
  std::string name;  // relative to COLMAP's image_path
  std::vector<Observation> observations;
};

struct TrackElement {
  uint32_t image = 0, observation = 0;
};

struct SparsePoint {
  int64_t id = 0;
  std::array<double, 3> xyz = {};
  std::array<uint8_t, 3> rgb = {};
  double error = 0.0;  // mean reprojection error, pixels
  std::vector<TrackElement> track;
};

struct SparseModel {
  std::string folder;  // from which it was read
  bool is_text = false;
  std::vector<SparseCamera> cameras;
  std::vector<SparseImage> images;
  std::vector<SparsePoint> points;
};

// Places of items by their ids.
template <typename Item>
auto PlacesById(const std::vector<Item>& items) {
  std::unordered_map<decltype(Item::id), size_t> places;
  places.reserve(items.size());
  for (size_t i = 0; i < items.size(); ++i) places.emplace(items[i].id, i);
  return places;
}

// path: the folder, or one with a model in sparse/0, sparse or 0. NotFound if there is none;
// DataLoss, naming the file, if it is damaged or refers to what it lacks. Without `with_points`,
// points3D is not read.
absl::StatusOr<SparseModel> ReadSparseModel(const std::string& path, bool with_points);

// Writes the model in the form in which it was read, and copies its rigs and frames, to a folder
// that is made. Errors of kernels/files/atomic_file.h.
absl::Status WriteSparseModel(const SparseModel& model, const std::string& folder);

}  // namespace egosieve::tools
