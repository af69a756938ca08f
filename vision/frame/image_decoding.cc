#include "vision/frame/image_decoding.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "vision/frame/pixel_limit.h"
#include "vision/frame/quiet_libraries.h"

namespace egosieve::vision {
namespace {

constexpr std::array<std::string_view, 13> kImageExtensions = {
    ".png", ".jpg", ".jpeg", ".jpe", ".bmp",  ".tif", ".tiff",
    ".pgm", ".ppm", ".pnm",  ".pbm", ".webp", ".jp2"};

constexpr int64_t kMaximumBytes = std::numeric_limits<int>::max();  // they are one row of a cv::Mat

// Whether the bytes begin like a picture of kImageExtensions. OpenCV passes all others to GDAL and
// GDCM, which end the process on some inputs.
bool BeginsAsPicture(std::string_view bytes) {
  constexpr std::string_view kBegins[] = {"\x89PNG",    "\xff\xd8\xff",      "BM",
                                          {"II*\0", 4}, {"MM\0*", 4},        {"II+\0", 4},
                                          {"MM\0+", 4}, {"\0\0\0\x0cjP", 6}, "\xff\x4f\xff\x51"};
  if (bytes.size() > 12 && bytes.starts_with("RIFF")) return bytes.substr(8, 4) == "WEBP";
  if (bytes.size() > 2 && bytes[0] == 'P') return bytes[1] >= '1' && bytes[1] <= '7';
  return std::any_of(std::begin(kBegins), std::end(kBegins),
                     [&](std::string_view begin) { return bytes.starts_with(begin); });
}

// Checked first, since decoders fill missing parts with grey or black and report it on stderr only.
bool IsCutShort(std::string_view bytes) {
  constexpr size_t kTrailerBytes = 4096;  // some cameras append a little behind the end marker
  const size_t tail = bytes.size() > kTrailerBytes ? bytes.size() - kTrailerBytes : 0;
  const auto ends_with = [&](std::string_view marker) {
    return bytes.find(marker, tail) != std::string_view::npos;
  };
  if (bytes.starts_with("\x89PNG")) return !ends_with("IEND");
  if (bytes.starts_with("\xff\xd8\xff")) return !ends_with("\xff\xd9");
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
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes, kernels::ReadFile(path, kMaximumBytes));
  if (bytes.empty()) return absl::DataLossError(absl::StrCat(path, ": the file is empty"));
  if (!BeginsAsPicture(bytes))
    return absl::DataLossError(absl::StrCat(path, ": cannot be decoded as a picture"));
  if (IsCutShort(bytes))
    return absl::DataLossError(absl::StrCat(path, ": the picture is cut short"));
  if (const absl::Status size = CheckPixelsOfFile(bytes); !size.ok()) {
    return absl::DataLossError(absl::StrCat(path, ": ", size.message()));
  }
  cv::Mat picture;
  try {
    const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
    picture = cv::imdecode(row, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR);
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
