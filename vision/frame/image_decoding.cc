#include "vision/frame/image_decoding.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/pixel_limit.h"
#include "vision/frame/quiet_libraries.h"

namespace egosieve::vision {
namespace {

constexpr std::array<std::string_view, 13> kImageExtensions = {
    ".png", ".jpg", ".jpeg", ".jpe", ".bmp",  ".tif", ".tiff",
    ".pgm", ".ppm", ".pnm",  ".pbm", ".webp", ".jp2"};

bool Contains(const std::vector<uint8_t>& bytes, size_t from, std::string_view pattern) {
  const auto begin = bytes.begin() + static_cast<ptrdiff_t>(std::min(from, bytes.size()));
  return std::search(begin, bytes.end(), pattern.begin(), pattern.end(),
                     [](uint8_t a, char b) { return a == static_cast<uint8_t>(b); }) != bytes.end();
}

bool StartsWith(const std::vector<uint8_t>& bytes, std::string_view pattern) {
  return bytes.size() >= pattern.size() &&
         std::equal(pattern.begin(), pattern.end(), bytes.begin(),
                    [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
}

// The decoders fill what is missing with grey or black and say so on stderr only; so look first.
bool IsCutShort(const std::vector<uint8_t>& bytes) {
  constexpr size_t kTrailerBytes = 4096;  // some cameras append a little behind the end marker
  const size_t tail = bytes.size() > kTrailerBytes ? bytes.size() - kTrailerBytes : 0;
  if (StartsWith(bytes, "\x89PNG")) return !Contains(bytes, tail, "IEND");
  if (StartsWith(bytes, "\xff\xd8\xff")) return !Contains(bytes, tail, "\xff\xd9");
  return false;
}

}  // namespace

bool HasImageExtension(const std::string& path) {
  const std::string extension =
      absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
  return std::find(kImageExtensions.begin(), kImageExtensions.end(), extension) !=
         kImageExtensions.end();
}

absl::StatusOr<DecodedImage> ConvertToBgr(const cv::Mat& picture) {
  if (picture.empty()) return absl::InvalidArgumentError("the picture has no pixels");
  EGOSIEVE_RETURN_IF_ERROR(CheckPixels(picture.cols, picture.rows));
  cv::Mat bytes;
  switch (picture.depth()) {
    case CV_8U:
      bytes = picture;
      break;
    case CV_16U:
      picture.convertTo(bytes, CV_8U, 1.0 / 257.0);
      break;
    case CV_32F:
    case CV_64F:
      picture.convertTo(bytes, CV_8U, 255.0);
      break;
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("pictures of OpenCV depth ", picture.depth(), " are not supported"));
  }
  DecodedImage result;
  switch (bytes.channels()) {
    case 1:
      cv::cvtColor(bytes, result.image, cv::COLOR_GRAY2BGR);
      result.is_grey = true;
      return result;
    case 3:
      result.image = bytes;
      return result;
    case 4:
      cv::cvtColor(bytes, result.image, cv::COLOR_BGRA2BGR);
      return result;
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("pictures of ", bytes.channels(), " channels are not supported"));
  }
}

absl::StatusOr<DecodedImage> DecodeImageFile(const std::string& path) {
  QuietLibraries();
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::NotFoundError(absl::StrCat(path, ": cannot be opened for reading"));
  const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file),
                                   std::istreambuf_iterator<char>()};
  if (bytes.empty()) return absl::DataLossError(absl::StrCat(path, ": the file is empty"));
  if (IsCutShort(bytes))
    return absl::DataLossError(absl::StrCat(path, ": the picture is cut short"));
  if (const absl::Status size =
          CheckPixelsOfFile({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      !size.ok()) {
    return absl::DataLossError(absl::StrCat(path, ": ", size.message()));
  }
  cv::Mat picture;
  try {
    picture = cv::imdecode(bytes, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR);
  } catch (const cv::Exception& error) {
    return absl::DataLossError(absl::StrCat(path, ": cannot be decoded (", error.err, ")"));
  }
  if (picture.empty())
    return absl::DataLossError(absl::StrCat(path, ": cannot be decoded as a picture"));
  absl::StatusOr<DecodedImage> converted = ConvertToBgr(picture);
  if (!converted.ok()) {
    return absl::DataLossError(absl::StrCat(path, ": ", converted.status().message()));
  }
  return converted;
}

}  // namespace egosieve::vision
