#include "tools/masks/truth_masks.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/map_image.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/image_decoding.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// The images in a folder, in natural order; empty if there are none, or no folder.
std::vector<std::string> ListImages(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string path = entry.path().string();
    if (entry.is_regular_file(error) && entry.path().filename().string().front() != '.' &&
        vision::HasImageExtension(path)) {
      files.push_back(path);
    }
  }
  std::sort(files.begin(), files.end(), vision::NaturalLess);
  return files;
}

std::string Stem(const std::string& path) { return fs::path(path).stem().string(); }

absl::StatusOr<std::vector<std::string>> ListMaskFiles(const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return absl::NotFoundError(
        absl::StrCat("no folder ", folder, "; give the folder of masks to --truth"));
  }
  std::vector<std::string> files = ListImages(folder);
  if (files.empty()) {
    return absl::NotFoundError(
        absl::StrCat("no image in ", folder, "; give the folder of masks to --truth"));
  }
  return files;
}

// Empty if a file has not the name of a frame, or two files have that of one frame.
std::map<int64_t, std::string> ByName(const std::vector<std::string>& files,
                                      const std::vector<std::string>& frame_names) {
  std::map<std::string, int64_t> indices;
  for (size_t i = 0; i < frame_names.size(); ++i) {
    indices[frame_names[i]] = static_cast<int64_t>(i);
  }
  std::map<int64_t, std::string> paths;
  for (const std::string& file : files) {
    const auto index = indices.find(Stem(file));
    if (index == indices.end() || !paths.emplace(index->second, file).second) {
      return {};
    }
  }
  return paths;
}

// The last run of digits in a name without its extension: 121 in "frame_0121".
std::optional<int64_t> NumberInName(const std::string& stem) {
  size_t end = stem.size();
  while (end > 0 && std::isdigit(static_cast<unsigned char>(stem[end - 1])) == 0) --end;
  size_t begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(stem[begin - 1])) != 0) --begin;
  int64_t number = 0;
  if (begin == end || !absl::SimpleAtoi(stem.substr(begin, end - begin), &number)) {
    return std::nullopt;
  }
  return number;
}

// Empty if a file's name has no number, or two have the same number.
std::map<int64_t, std::string> ByNumber(const std::vector<std::string>& files) {
  std::map<int64_t, std::string> paths;
  for (const std::string& file : files) {
    const std::optional<int64_t> number = NumberInName(Stem(file));
    if (!number || !paths.emplace(*number, file).second) {
      return {};
    }
  }
  return paths;
}

std::map<int64_t, std::string> ByOrder(const std::vector<std::string>& files) {
  std::map<int64_t, std::string> paths;
  for (size_t i = 0; i < files.size(); ++i) {
    paths[static_cast<int64_t>(i)] = files[i];
  }
  return paths;
}

}  // namespace

std::vector<std::string> FrameNames(const std::string& path) {
  std::vector<std::string> names = ListImages(path);
  std::transform(names.begin(), names.end(), names.begin(), Stem);
  return names;
}

absl::StatusOr<std::map<int64_t, std::string>> ListTruthMasks(
    const std::string& folder, const std::vector<std::string>& frame_names) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<std::string> files, ListMaskFiles(folder));
  std::map<int64_t, std::string> paths = ByName(files, frame_names);
  if (paths.empty()) paths = ByNumber(files);
  if (!paths.empty()) return paths;
  if (!frame_names.empty() && files.size() != frame_names.size()) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "the %d masks in %s have neither the names nor the numbers of the %d frames; rename them",
        files.size(), folder, frame_names.size()));
  }
  return ByOrder(files);
}

absl::StatusOr<cv::Mat1b> ReadTruthMask(const std::string& path, cv::Size expected) {
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat image, ReadImage(path, cv::IMREAD_ANYCOLOR));
  if (image.depth() != CV_8U) {
    return absl::DataLossError(
        absl::StrCat("the mask ", path, " has no 8-bit pixels; remove or replace it"));
  }
  if (image.size() != expected) {
    return absl::OutOfRangeError(absl::StrFormat(
        "the mask %s has %d x %d pixels, its frame %d x %d; give the masks of this drive", path,
        image.cols, image.rows, expected.width, expected.height));
  }
  const int channels = image.channels();
  cv::Mat1b truth(image.size());
  for (int y = 0; y < image.rows; ++y) {
    const uint8_t* row = image.ptr<uint8_t>(y);
    for (int x = 0; x < image.cols; ++x) {
      const uint8_t* pixel = row + static_cast<ptrdiff_t>(x) * channels;
      const auto all_are = [&](uint8_t value) {
        return std::all_of(pixel, pixel + channels, [value](uint8_t v) { return v == value; });
      };
      truth(y, x) = all_are(0) ? kTruthStatic : all_are(kTruthVoid) ? kTruthVoid : kTruthDynamic;
    }
  }
  return truth;
}

}  // namespace egosieve::tools
