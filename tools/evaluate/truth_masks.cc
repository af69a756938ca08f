#include "tools/evaluate/truth_masks.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

bool IsMaskFile(const fs::path& path) {
  static const std::set<std::string>& extensions =
      *new std::set<std::string>{".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".tif", ".tiff"};
  return extensions.count(absl::AsciiStrToLower(path.extension().string())) > 0 &&
         path.filename().string().front() != '.';
}

// The last run of digits in a file's name.
std::optional<int64_t> NumberIn(const std::string& path) {
  const std::string stem = fs::path(path).stem().string();
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

absl::StatusOr<std::vector<std::string>> ListMaskFiles(const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return absl::NotFoundError(
        absl::StrCat("no folder ", folder, "; give the folder of masks to --truth"));
  }
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_regular_file(error) && IsMaskFile(entry.path())) {
      files.push_back(entry.path().string());
    }
  }
  if (files.empty()) {
    return absl::NotFoundError(
        absl::StrCat("no image in ", folder, "; give the folder of masks to --truth"));
  }
  std::sort(files.begin(), files.end(), vision::NaturalLess);
  return files;
}

std::map<int64_t, std::string> ByNumber(const std::vector<std::string>& files) {
  std::map<int64_t, std::string> paths;
  for (const std::string& file : files) {
    const std::optional<int64_t> number = NumberIn(file);
    if (!number || !paths.emplace(*number, file).second) {
      return {};
    }
  }
  return paths;
}

}  // namespace

absl::StatusOr<TruthMasks> ListTruthMasks(const std::string& folder, MatchMasks match) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<std::string> files, ListMaskFiles(folder));
  TruthMasks masks{folder, "number", {}};
  if (match != MatchMasks::kOrder) {
    masks.paths = ByNumber(files);
    if (!masks.paths.empty()) {
      return masks;
    }
    if (match == MatchMasks::kNumber) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the masks in ", folder,
          " have no number each, or the same one twice; rename them or use --match=order"));
    }
  }
  masks.matched_by = "order";
  for (size_t i = 0; i < files.size(); ++i) {
    masks.paths[static_cast<int64_t>(i)] = files[i];
  }
  return masks;
}

absl::StatusOr<cv::Mat1b> ReadTruthMask(const std::string& path, cv::Size expected) {
  cv::Mat image;
  try {
    image = cv::imread(path, cv::IMREAD_ANYCOLOR);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty() || image.depth() != CV_8U) {
    return absl::DataLossError(
        absl::StrCat("the mask ", path, " is no image that can be read; remove or replace it"));
  }
  if (image.size() != expected) {
    return absl::DataLossError(absl::StrFormat(
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
