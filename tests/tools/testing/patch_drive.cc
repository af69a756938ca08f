#include "tests/tools/testing/patch_drive.h"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <random>

#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

// Random blobs at two scales, about `base`: structure for corners and for descriptors.
cv::Mat3b Texture(cv::Size size, uint64_t seed, const cv::Scalar& base) {
  std::mt19937_64 random(seed);
  cv::Mat3b texture(size);
  texture.setTo(base);
  for (int i = 0; i < size.area() / 60; ++i) {
    const cv::Point centre(static_cast<int>(random() % size.width),
                           static_cast<int>(random() % size.height));
    const int radius = 2 + static_cast<int>(random() % (i % 5 == 0 ? 9 : 4));
    const double change = static_cast<double>(random() % 120) - 60.0;
    cv::circle(texture, centre, radius, base + cv::Scalar(change, change * 0.8, change * 0.9),
               cv::FILLED, cv::LINE_AA);
  }
  cv::GaussianBlur(texture, texture, cv::Size(), 0.7);
  return texture;
}

cv::Rect Square(const PatchDriveOptions& options, int index) {
  const int side = options.height_pixels / 3;
  const int x = (options.width_pixels / 8 + 5 * index) % (options.width_pixels - side);
  return cv::Rect(x, options.height_pixels / 3, side, side);
}

}  // namespace

cv::Mat3b PatchFrame(const PatchDriveOptions& options, int index) {
  const cv::Size size(options.width_pixels, options.height_pixels);
  const cv::Mat3b plane =
      Texture(cv::Size(size.width + 3 * options.frames, size.height), 1, {110, 110, 105});
  const cv::Mat3b square = Texture(cv::Size(size.height, size.height), 2, {60, 80, 190});
  cv::Mat3b frame = plane(cv::Rect(cv::Point(3 * index, 0), size)).clone();
  const cv::Rect place = Square(options, index);
  square(cv::Rect(cv::Point(0, 0), place.size())).copyTo(frame(place));
  return frame;
}

cv::Mat1b PatchMask(const PatchDriveOptions& options, int index) {
  cv::Mat1b mask(options.height_pixels, options.width_pixels, uint8_t{0});
  mask(Square(options, index)).setTo(255);
  return mask;
}

void WritePatchDrive(const std::string& root, const PatchDriveOptions& options) {
  std::filesystem::remove_all(root);
  std::filesystem::create_directories(root + "/frames");
  std::filesystem::create_directories(root + "/masks");
  for (int index = 0; index < options.frames; ++index) {
    const std::string name = absl::StrFormat("/%06d.png", index);
    cv::imwrite(root + "/frames" + name, PatchFrame(options, index));
    cv::imwrite(root + "/masks" + name, PatchMask(options, index));
  }
}

void WritePatchVideo(const std::string& path, const PatchDriveOptions& options, int frames) {
  cv::VideoWriter writer(path, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10,
                         cv::Size(options.width_pixels, options.height_pixels));
  CV_Assert(writer.isOpened());
  for (int i = 0; i < frames; ++i) writer.write(PatchFrame(options, i));
}

}  // namespace egosieve::tools
