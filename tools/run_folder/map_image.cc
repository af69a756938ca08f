#include "tools/run_folder/map_image.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

constexpr double kFullPixel = 65535.0;
constexpr int64_t kMaximumBytes = std::numeric_limits<int>::max();  // longest row in OpenCV

}  // namespace

absl::StatusOr<std::string> EncodePng(const cv::Mat& image) {
  // Level 1, Sub filter: faster than the defaults, at slightly larger files.
  const std::vector<int> flags = {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY,
                                  cv::IMWRITE_PNG_STRATEGY_FILTERED};
  std::vector<uchar> bytes;
  try {
    if (!cv::imencode(".png", image, bytes, flags)) {
      return absl::InternalError("the PNG encoder failed");
    }
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrFormat("the PNG encoder failed: %s", error.what()));
  }
  return std::string(bytes.begin(), bytes.end());
}

absl::Status WritePng(const std::string& path, const cv::Mat& image) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string png, EncodePng(image));
  return WriteFileAtomically(path, png);
}

cv::Mat1w MapPixels(const cv::Mat1f& values, double full_scale) {
  cv::Mat1w pixels(values.size());
  for (int row = 0; row < values.rows; ++row) {
    for (int column = 0; column < values.cols; ++column) {
      const double share = std::min(values(row, column) / full_scale, 1.0);
      pixels(row, column) = static_cast<uint16_t>(std::lround(kFullPixel * share));
    }
  }
  return pixels;
}

cv::Mat1f MapValues(const cv::Mat1w& pixels, double full_scale) {
  cv::Mat1f values;
  pixels.convertTo(values, CV_32F, full_scale / kFullPixel);
  return values;
}

absl::StatusOr<EncodedMap> EncodeMap(const cv::Mat1f& values, double full_scale) {
  EncodedMap encoded;
  for (int row = 0; row < values.rows; ++row) {
    for (int column = 0; column < values.cols; ++column) {
      const double value = values(row, column);
      if (!(value >= 0.0)) {
        return absl::InvalidArgumentError(absl::StrFormat(
            "map value %g at column %d, row %d; it must not be negative", value, column, row));
      }
      encoded.saturated += value > full_scale;
    }
  }
  EGOSIEVE_ASSIGN_OR_RETURN(encoded.png, EncodePng(MapPixels(values, full_scale)));
  return encoded;
}

absl::StatusOr<cv::Mat> ReadImage(const std::string& path, int flags) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path, kMaximumBytes));
  cv::Mat image;
  try {
    if (!bytes.empty()) {
      const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
      image = cv::imdecode(row, flags);
    }
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) {
    return absl::DataLossError(
        absl::StrFormat("%s is no image that can be read; remove or replace it", path));
  }
  return image;
}

absl::StatusOr<cv::Mat1f> ReadMap(const std::string& path, cv::Size expected, double full_scale) {
  absl::StatusOr<cv::Mat> read = ReadImage(path, cv::IMREAD_UNCHANGED);
  if (!read.ok() && !absl::IsDataLoss(read.status())) return read.status();
  const cv::Mat pixels = read.ok() ? *std::move(read) : cv::Mat();
  if (pixels.type() != CV_16UC1) {
    return absl::DataLossError(
        absl::StrFormat("%s is not a 16-bit grey image; segment the drive again", path));
  }
  if (pixels.size() != expected) {
    return absl::DataLossError(absl::StrFormat(
        "%s has %d x %d pixels where run.json says %d x %d; segment the drive again", path,
        pixels.cols, pixels.rows, expected.width, expected.height));
  }
  return MapValues(pixels, full_scale);
}

}  // namespace egosieve::tools
