// Masks of the pictures that COLMAP's image_undistorter writes, from masks of the original ones.
//
//   (x, y)   centre of a pixel of the undistorted picture, its upper left one at (0.5, 0.5)
//   (u, v)   ((x - cx) / fx, (y - cy) / fy), its ray by the undistorted camera, a pinhole    (UD1)
//   (x', y') pixels of the original picture, the ray's projection by its camera (lens.h)     (UD2)
//   masked   as the original pixel (floor x', floor y'); masked without such a pixel         (UD3)
//
// Both cameras are those of COLMAP's models, so that scales, blank pixels and cuts are COLMAP's.
// Pictures whose cameras are equal in both models keep their masks: COLMAP copies them.
// Where a distortion folds the picture, COLMAP's warp shows pixels twice, and so does (UD2).
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/colmap/sparse_model.h"
#include "tools/masks/mask_writer.h"

namespace egosieve::tools {

class Undistortion {
 public:
  // dense: the folder that image_undistorter wrote; sparse: the model of the original pictures that
  // it read. Images belong together by their names. images: names of the input's pictures; size: of
  // the first one, in pixels. Errors of ReadSparseModel; InvalidArgument if no picture is in both
  // models, or the cameras of one are of models that (UD1) or (UD2) lack; OutOfRange if `size` is
  // not that of its camera; NotFound if an undistorted picture is missing and `with_pictures`.
  static absl::StatusOr<Undistortion> Open(const std::string& dense, const std::string& sparse,
                                           const std::vector<std::string>& images, cv::Size size,
                                           bool with_pictures);

  // Whether an image is in both models.
  bool Holds(const std::string& image) const { return cameras_.count(image) > 0; }
  // (UD3) of an image that Holds: its mask, its numbers and, if wanted, the undistorted picture.
  // OutOfRange if one of them is not of its camera's size; errors of ReadImage.
  absl::Status Apply(MaskedFrame& frame) const;

 private:
  absl::Status CheckSize(const std::string& image, cv::Size size) const;
  std::string Picture(const std::string& image) const { return dense_ + "/images/" + image; }

  std::string dense_, sparse_;
  bool with_pictures_ = false;
  // The original and the undistorted camera, by image.
  std::map<std::string, std::pair<SparseCamera, SparseCamera>> cameras_;
};

}  // namespace egosieve::tools
