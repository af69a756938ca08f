#include "tools/masks/mask_writer.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/masks/run_length.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/json_name.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

// Labels as an 8-bit PNG with a palette, as the readers of DAVIS and PASCAL VOC expect: a pixel is
// its label, 0 to 255. The colours are those of VOC; no reader needs them.

constexpr int kLabels = 256;

// Bits 0, 3 and 6 of the label are the most significant bits of red; bits 1, 4, 7 those of green,
// and bits 2, 5 those of blue.
std::array<uint8_t, 3 * kLabels> VocColours() {
  std::array<uint8_t, 3 * kLabels> colours = {};
  for (int label = 0; label < kLabels; ++label) {
    for (int bit = 0; bit < 8; ++bit) {
      colours[3 * label + bit % 3] |= ((label >> bit) & 1) << (7 - bit / 3);
    }
  }
  return colours;
}

absl::StatusOr<std::string> EncodePalettePng(const cv::Mat1b& labels) {
  static const std::array<uint8_t, 3 * kLabels> colours = VocColours();
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(labels.cols);
  image.height = static_cast<png_uint_32>(labels.rows);
  image.format = PNG_FORMAT_RGB_COLORMAP;
  image.colormap_entries = kLabels;
  image.flags = PNG_IMAGE_FLAG_FAST;
  const cv::Mat1b pixels = labels.isContinuous() ? labels : labels.clone();
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data, 0, colours.data()) ==
      0) {
    return absl::InternalError(absl::StrCat("the PNG encoder failed: ", image.message));
  }
  bytes.resize(size);
  return bytes;
}

// The single class for COCO and MOTS: movers. In MOTS, 1 is a car, 2 a pedestrian.
constexpr int kClass = 1;

std::set<int> NumbersIn(const cv::Mat1w& numbers) {
  std::set<int> found(numbers.begin(), numbers.end());
  found.erase(0);
  return found;
}

// The picture with an alpha channel, 0 where masked.
cv::Mat WithAlpha(const cv::Mat3b& picture, const cv::Mat1b& masked) {
  std::vector<cv::Mat> channels;
  cv::split(picture, channels);
  channels.push_back(masked == 0);
  cv::Mat image;
  cv::merge(channels, image);
  return image;
}

}  // namespace

absl::Status MaskWriter::Write(const MaskedFrame& frame) {
  if (format_ == MaskFormat::kCoco) {
    AddAnnotations(frame);
    return absl::OkStatus();
  }
  if (format_ == MaskFormat::kDavis) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string png, EncodePalettePng(cv::Mat1b(frame.numbers)));
    return WriteFile(MaskFile(format_, frame.image, frame.index, sequence_), png);
  }
  cv::Mat image;
  switch (RowOf(format_).masked) {
    case MaskedPixel::kNumber: {
      AddRows(frame);
      cv::Mat1w objects = frame.numbers + cv::Scalar(kMotsClassStep * kClass);
      objects.setTo(0, frame.numbers == 0);
      image = objects;
      break;
    }
    case MaskedPixel::kTransparent:
      image = WithAlpha(frame.picture, frame.masked);
      break;
    case MaskedPixel::kBlack:
      image = frame.masked == 0;
      break;
    case MaskedPixel::kWhite:
      image = frame.masked;
      break;
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string png, EncodePng(image));
  return WriteFile(MaskFile(format_, frame.image, frame.index, sequence_), png);
}

absl::Status MaskWriter::WriteReduced(const MaskedFrame& frame, int by) const {
  const cv::Size size(std::max(frame.masked.cols / by, 1), std::max(frame.masked.rows / by, 1));
  cv::Mat1f share;
  cv::resize(cv::Mat1f(frame.masked), share, size, 0, 0, cv::INTER_AREA);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string png, EncodePng(share == 0.0F));
  return WriteFile(ReducedMaskFile(frame.image, by), png);
}

absl::Status MaskWriter::WriteFile(const std::string& name, const std::string& bytes) const {
  const std::filesystem::path path = std::filesystem::path(folder_) / name;
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(path.parent_path().string()));
  return WriteFileAtomically(path.string(), bytes);
}

void MaskWriter::AddAnnotations(const MaskedFrame& frame) {
  const int64_t image_id = frame.index + 1;
  images_.push_back({{"id", image_id},
                     {"file_name", JsonName(frame.image)},
                     {"width", frame.numbers.cols},
                     {"height", frame.numbers.rows},
                     {"frame_id", frame.index}});
  for (const int number : NumbersIn(frame.numbers)) {
    const cv::Mat1b mask = frame.numbers == number;
    const cv::Rect box = cv::boundingRect(mask);
    annotations_.push_back(
        {{"id", annotations_.size() + 1},
         {"image_id", image_id},
         {"category_id", kClass},
         {"track_id", number},
         {"segmentation",
          {{"size", {mask.rows, mask.cols}}, {"counts", RunLengthText(RunLengths(mask))}}},
         {"area", cv::countNonZero(mask)},
         {"bbox", {box.x, box.y, box.width, box.height}},
         {"iscrowd", 0}});
  }
}

void MaskWriter::AddRows(const MaskedFrame& frame) {
  for (const int number : NumbersIn(frame.numbers)) {
    absl::StrAppendFormat(&rows_, "%d %d %d %d %d %s\n", frame.index,
                          kMotsClassStep * kClass + number, kClass, frame.numbers.rows,
                          frame.numbers.cols, RunLengthText(RunLengths(frame.numbers == number)));
  }
}

absl::Status MaskWriter::Finish() {
  if (format_ == MaskFormat::kMots) {
    return WriteFileAtomically(absl::StrCat(folder_, "/", sequence_, ".txt"), rows_);
  }
  if (format_ != MaskFormat::kCoco) return absl::OkStatus();
  const nlohmann::ordered_json json = {
      {"info", {{"description", "what moves by itself, by egosieve"}}},
      {"categories", nlohmann::ordered_json::array(
                         {{{"id", kClass}, {"name", "moving"}, {"supercategory", ""}}})},
      {"images", images_},
      {"annotations", annotations_}};
  return WriteFileAtomically(absl::StrCat(folder_, "/annotations.json"), json.dump() + "\n");
}

}  // namespace egosieve::tools
