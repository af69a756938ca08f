#include "tools/masks/user_masks.h"

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// Path of the picture's mask in the folder; empty if there is none.
std::string PathOf(const fs::path& folder, const std::string& image) {
  std::error_code error;
  for (const fs::path& name :
       {fs::path(image + ".png"), fs::path(image).replace_extension(".png"), fs::path(image)}) {
    if (fs::is_regular_file(folder / name, error)) return (folder / name).string();
  }
  return "";
}

absl::StatusOr<cv::Mat1b> ReadMask(const std::string& path, cv::Size size) {
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat image,
                            ReadImage(path, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION));
  if (image.size() != size) {
    return absl::OutOfRangeError(
        absl::StrFormat("--also: %s has %d x %d pixels, its image %d x %d; give masks of the "
                        "images' size",
                        path, image.cols, image.rows, size.width, size.height));
  }
  return cv::Mat1b(image);
}

}  // namespace

absl::StatusOr<UserMasks> UserMasks::Open(const std::string& path,
                                          const std::vector<std::string>& images, cv::Size size) {
  UserMasks masks;
  if (path.empty()) return masks;
  masks.folder_ = path;
  std::error_code error;
  if (fs::is_directory(path, error)) {
    for (const std::string& image : images) masks.paths_.push_back(PathOf(path, image));
  } else if (fs::is_regular_file(path, error)) {
    masks.paths_.assign(images.size(), path);
  } else {
    return absl::NotFoundError(
        absl::StrCat("--also=", path, ": no such folder or picture; check the path"));
  }
  const auto first = std::find_if(masks.paths_.begin(), masks.paths_.end(),
                                  [](const std::string& mask) { return !mask.empty(); });
  if (first == masks.paths_.end()) {
    return absl::NotFoundError(
        absl::StrCat("--also=", path, " holds no mask of any image; name them after the images, ",
                     images.empty() ? "IMAGE" : images.front(), ".png"));
  }
  EGOSIEVE_RETURN_IF_ERROR(ReadMask(*first, size).status());
  return masks;
}

std::string UserMasks::Describe() const {
  const auto lacking = std::count(paths_.begin(), paths_.end(), "");
  return lacking == 0 ? ""
                      : absl::StrCat(lacking, " of ", paths_.size(), " images have no mask in ",
                                     folder_, "; they have ours alone");
}

absl::Status UserMasks::AddTo(int64_t index, cv::Mat1b& masked) const {
  if (index >= static_cast<int64_t>(paths_.size()) || paths_[index].empty()) {
    return absl::OkStatus();
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1b own, ReadMask(paths_[index], masked.size()));
  masked.setTo(255, own);
  return absl::OkStatus();
}

}  // namespace egosieve::tools
