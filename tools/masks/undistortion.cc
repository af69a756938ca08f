#include "tools/masks/undistortion.h"

#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/colmap/lens.h"
#include "tools/masks/stored_picture.h"

namespace egosieve::tools {
namespace {

// Of a picture of COLMAP, in pixels.
constexpr uint64_t kLongestSide = 65535, kLargestArea = uint64_t{1} << 29;

// Whether image_undistorter left the picture as it was.
bool IsUnchanged(const SparseCamera& original, const SparseCamera& undistorted) {
  return original.model == undistorted.model && original.width == undistorted.width &&
         original.height == undistorted.height && original.parameters == undistorted.parameters;
}

absl::Status CheckCameras(const SparseCamera& original, const SparseCamera& undistorted) {
  if (IsUnchanged(original, undistorted)) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(LensOf(original).status());
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::Lens pinhole, LensOf(undistorted));
  if (!pinhole.is_pinhole()) {
    return absl::InvalidArgumentError(
        absl::StrCat("its camera ", undistorted.id,
                     " has distortion, so its pictures are not "
                     "those of image_undistorter; name what that wrote"));
  }
  const uint64_t width = undistorted.width, height = undistorted.height;
  if (width == 0 || height == 0 || width > kLongestSide || height > kLongestSide ||
      width * height > kLargestArea) {
    return absl::InvalidArgumentError(absl::StrCat("its camera ", undistorted.id, " has ", width,
                                                   " x ", height, " pixels, more than a picture"));
  }
  return absl::OkStatus();
}

// (UD1) to (UD3)
template <typename Pixel>
cv::Mat_<Pixel> Undistort(const cv::Mat_<Pixel>& from, const vision::Lens& original,
                          const vision::Lens& pinhole, cv::Size size, Pixel outside) {
  cv::Mat_<Pixel> to(size, outside);
  kernels::ParallelFor(size.height, [&](int64_t row) {
    const int y = static_cast<int>(row);
    const double v = (y + 0.5 - pinhole.cy) / pinhole.fy;
    for (int x = 0; x < size.width; ++x) {
      const auto [from_x, from_y] = original.Project((x + 0.5 - pinhole.cx) / pinhole.fx, v);
      if (from_x >= 0.0 && from_x < from.cols && from_y >= 0.0 && from_y < from.rows) {
        to(y, x) = from(static_cast<int>(from_y), static_cast<int>(from_x));
      }
    }
  });
  return to;
}

}  // namespace

absl::StatusOr<Undistortion> Undistortion::Open(const std::string& dense, const std::string& sparse,
                                                const std::vector<std::string>& images,
                                                cv::Size size, bool with_pictures) {
  EGOSIEVE_ASSIGN_OR_RETURN(const SparseModel from, ReadSparseModel(sparse, false));
  EGOSIEVE_ASSIGN_OR_RETURN(const SparseModel to, ReadSparseModel(dense, false));
  const auto from_cameras = PlacesById(from.cameras), to_cameras = PlacesById(to.cameras);
  Undistortion result;
  result.dense_ = dense;
  result.sparse_ = sparse;
  result.with_pictures_ = with_pictures;
  std::map<std::string, SparseCamera> originals;
  for (const SparseImage& image : from.images) {
    originals[image.name] = from.cameras[from_cameras.at(image.camera)];
  }
  for (const SparseImage& image : to.images) {
    const auto original = originals.find(image.name);
    if (original == originals.end()) continue;
    const SparseCamera& undistorted = to.cameras[to_cameras.at(image.camera)];
    const absl::Status status = CheckCameras(original->second, undistorted);
    if (!status.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat(dense, ", image ", image.name, ": ", status.message()));
    }
    result.cameras_.try_emplace(image.name, original->second, undistorted);
  }
  if (result.cameras_.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("no image of ", dense, " is in ", sparse,
                     "; --undistort takes what image_undistorter wrote, --sparse what it read"));
  }
  bool holds_any = false;
  for (const std::string& image : images) {
    std::error_code error;
    if (!result.Holds(image)) continue;
    if (with_pictures && !std::filesystem::exists(result.Picture(image), error)) {
      return absl::NotFoundError(absl::StrCat(
          result.Picture(image), " is missing; --undistort takes what image_undistorter wrote"));
    }
    holds_any = true;
  }
  if (!holds_any) {
    return absl::InvalidArgumentError(
        absl::StrCat("no picture of the input is in ", sparse, ", as ",
                     images.empty() ? "IMAGE" : images.front(),
                     "; give the folder that was COLMAP's image_path"));
  }
  if (result.Holds(images.front())) {
    EGOSIEVE_RETURN_IF_ERROR(result.CheckSize(images.front(), size));
  }
  return result;
}

absl::Status Undistortion::CheckSize(const std::string& image, cv::Size size) const {
  const SparseCamera& camera = cameras_.at(image).first;
  if (camera.width == static_cast<uint64_t>(size.width) &&
      camera.height == static_cast<uint64_t>(size.height)) {
    return absl::OkStatus();
  }
  return absl::OutOfRangeError(absl::StrFormat(
      "%s has %d x %d pixels, its camera in %s %d x %d; give the model of these pictures", image,
      size.width, size.height, sparse_, camera.width, camera.height));
}

absl::Status Undistortion::Apply(MaskedFrame& frame) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckSize(frame.image, frame.masked.size()));
  const auto& [from, to] = cameras_.at(frame.image);
  const cv::Size size(static_cast<int>(to.width), static_cast<int>(to.height));
  if (!IsUnchanged(from, to)) {
    EGOSIEVE_ASSIGN_OR_RETURN(const vision::Lens original, LensOf(from));
    EGOSIEVE_ASSIGN_OR_RETURN(const vision::Lens pinhole, LensOf(to));
    frame.masked = Undistort<uint8_t>(frame.masked, original, pinhole, size, 255);
    if (!frame.numbers.empty()) {
      frame.numbers = Undistort<uint16_t>(frame.numbers, original, pinhole, size, 0);
    }
  }
  if (!with_pictures_) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const StoredPicture picture, ReadStoredPicture(Picture(frame.image)));
  frame.picture = picture.pixels;
  if (frame.picture.size() == size) return absl::OkStatus();
  return absl::OutOfRangeError(
      absl::StrCat(Picture(frame.image),
                   " has another size than its camera; let image_undistorter write both again"));
}

}  // namespace egosieve::tools
