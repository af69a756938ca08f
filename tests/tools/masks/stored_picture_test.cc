#include "tools/masks/stored_picture.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "tests/testing/status.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

// A JPEG whose EXIF has the orientation.
std::string JpegOf(const cv::Mat3b& pixels, char orientation) {
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", pixels, jpeg);
  std::string exif = {'E', 'x',  'i', 'f', 0, 0, 'M', 'M', 0, 42,          0, 0,
                      0,   8,                                                     // big-endian TIFF
                      0,   1,                                                     // one entry:
                      1,   0x12, 0,   3,   0, 0, 0,   1,   0, orientation, 0, 0,  // orientation
                      0,   0,    0,   0};
  const auto length = static_cast<char>(exif.size() + 2);
  const std::string header = std::string("\xff\xd8\xff\xe1", 4) + '\0' + length;
  return header + exif + std::string(jpeg.begin() + 2, jpeg.end());
}

TEST(StoredPicture, LiesAsItsFileDoesWhateverExifSays) {
  cv::Mat3b pixels(24, 40, cv::Vec3b(20, 20, 20));
  pixels(cv::Rect(0, 0, 16, 8)).setTo(cv::Scalar(0, 0, 250));
  for (char orientation = 1; orientation <= 8; ++orientation) {
    const std::string path = testing::TempDir() + "/turned.jpg";
    ASSERT_TRUE(WriteFileAtomically(path, JpegOf(pixels, orientation)).ok());
    const StoredPicture picture = Value(ReadStoredPicture(path));
    EXPECT_EQ(picture.orientation, orientation);
    EXPECT_EQ(picture.pixels.size(), pixels.size());
    const cv::Mat upright = cv::imread(path, cv::IMREAD_COLOR);
    EXPECT_EQ(upright.size(), orientation < 5 ? cv::Size(40, 24) : cv::Size(24, 40));
    EXPECT_EQ(cv::norm(TurnBack(upright, picture.orientation), picture.pixels, cv::NORM_INF), 0);
  }
}

}  // namespace
}  // namespace egosieve::tools
