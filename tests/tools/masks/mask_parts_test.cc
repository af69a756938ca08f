#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tools/masks/cast_shadows.h"
#include "tools/masks/frame_masks.h"
#include "tools/masks/run_length.h"
#include "tools/masks/stored_picture.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;
TEST(Dilate, ReachesAsFarAsItSaysAndNoFarther) {
  cv::Mat1b masked(41, 61, uint8_t{0});
  masked(20, 30) = 255;
  cv::Mat1w none;
  Dilate(10, masked, none);
  for (int y = 0; y < masked.rows; ++y) {
    for (int x = 0; x < masked.cols; ++x) {
      const int square = (y - 20) * (y - 20) + (x - 30) * (x - 30);
      EXPECT_EQ(masked(y, x) != 0, square <= 100) << x << "," << y;
    }
  }
}

TEST(Dilate, GivesPixelsTheNumberOfTheNearestMover) {
  cv::Mat1w numbers(20, 40, uint16_t{0});
  numbers(10, 10) = 3;
  numbers(10, 20) = 500;
  cv::Mat1b masked = numbers != 0;
  Dilate(8, masked, numbers);
  EXPECT_EQ(numbers(10, 14), 3);
  EXPECT_EQ(numbers(10, 16), 500);
  EXPECT_EQ(numbers(10, 28), 500);
  EXPECT_EQ(numbers(10, 29), 0);
  EXPECT_EQ(cv::countNonZero((numbers != 0) != (masked != 0)), 0);
}

TEST(Dilate, LeavesAPictureWithoutMoversEmpty) {
  cv::Mat1b masked(8, 8, uint8_t{0});
  cv::Mat1w none;
  Dilate(5, masked, none);
  EXPECT_EQ(cv::countNonZero(masked), 0);
}

TEST(ReadFrameMask, HasTheOwnVehicleWhereItIsWanted) {
  const RunFolder folder = Value(RunFolder::Create(FreshFolder(), false));
  FrameLine line{.width_pixels = 30, .height_pixels = 20};
  cv::Mat1b mask(20, 30, uint8_t{0});
  mask(2, 3) = 255;
  ASSERT_TRUE(CreateFolder(folder.File("masks")).ok());
  cv::imwrite(folder.FrameFile("masks", 0, ".png"), mask);
  FrameMaskOptions options;
  cv::Mat1b ignored(20, 30, uint8_t{0});
  ignored(cv::Rect(0, 15, 30, 5)) = 255;
  options.ignored.Add(0, ignored);
  absl::StatusOr<FrameMask> read = ReadFrameMask(folder, line, options);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(cv::countNonZero(read->masked != mask), 0);
  options.own_vehicle = true;
  read = ReadFrameMask(folder, line, options);
  ASSERT_TRUE(read.ok()) << read.status();
  mask(cv::Rect(0, 15, 30, 5)) = 255;
  EXPECT_EQ(cv::countNonZero(read->masked != mask), 0);

  ignored(0, 29) = 255;
  mask(0, 29) = 255;
  read = ReadFrameMask(folder, line, options);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(cv::countNonZero(read->masked != mask), 0);

  line.width_pixels = 31;
  EXPECT_EQ(ReadFrameMask(folder, line, options).status().code(), absl::StatusCode::kDataLoss);
}

// A grey ground, a mover that stands on it, and what is dark around it.

const cv::Size kSize(300, 200);
const cv::Rect kMover(140, 40, 30, 80);  // its feet at y = 120

class CastShadows : public testing::Test {
 protected:
  CastShadows() : picture_(kSize, cv::Vec3b(150, 160, 170)), moving_(kSize, uint8_t{0}) {
    Darken(kMover, 0.3);
    moving_(kMover) = 255;
  }

  void Darken(const cv::Rect& where, double share) {
    cv::Mat part = picture_(where);
    part *= share;
  }

  // Of a rectangle's pixels, less those of the mover.
  static double Share(const cv::Mat1b& shadows, const cv::Rect& where) {
    cv::Mat1b counted(kSize, uint8_t{0});
    counted(where) = 255;
    counted(kMover) = 0;
    return static_cast<double>(cv::countNonZero(shadows & counted)) / cv::countNonZero(counted);
  }

  cv::Mat3b picture_;
  cv::Mat1b moving_;
};

TEST_F(CastShadows, AreFoundWhereTheyBeginAtTheFeet) {
  const cv::Rect shadow(90, 112, 60, 20), stone(210, 110, 20, 20);
  Darken(shadow, 0.4);
  Darken(stone, 0.4);
  const cv::Mat1b found = FindCastShadows(picture_, moving_, 80);
  EXPECT_GT(Share(found, shadow), 0.85) << "smoothing takes a pixel at each edge";
  EXPECT_EQ(Share(found, stone), 0.0) << "it does not reach the feet";
  EXPECT_EQ(cv::countNonZero(found & moving_), 0) << "the mover is none";
  EXPECT_LT(cv::countNonZero(found), 1.1 * shadow.area()) << "and adds nothing";
}

TEST_F(CastShadows, EndAtTheMargin) {
  const cv::Rect shadow(20, 110, 120, 12);
  Darken(shadow, 0.4);
  const cv::Mat1b found = FindCastShadows(picture_, moving_, 50);
  EXPECT_GT(Share(found, {91, 110, 49, 12}), 0.8);
  EXPECT_EQ(Share(found, {20, 110, 69, 12}), 0.0);
  EXPECT_EQ(cv::countNonZero(FindCastShadows(picture_, moving_, 0)), 0);
}

// A hedge behind the mover; a puddle that is hardly darker; the next mover.
TEST_F(CastShadows, AreOnTheGroundAndDark) {
  const cv::Rect hedge(60, 50, 160, 40), puddle(100, 121, 100, 20);
  Darken(hedge, 0.3);
  Darken(puddle, 0.75);
  const cv::Mat1b found = FindCastShadows(picture_, moving_, 60);
  EXPECT_EQ(Share(found, hedge), 0.0);
  EXPECT_EQ(Share(found, puddle), 0.0);
  const cv::Rect next(172, 90, 20, 40);
  Darken(next, 0.3);
  moving_(next) = 255;
  EXPECT_EQ(Share(FindCastShadows(picture_, moving_, 60), next), 0.0);
}

TEST_F(CastShadows, OfSpecksAndAtTheEdgeDoNoHarm) {
  cv::Mat1b speck(kSize, uint8_t{0});
  speck(cv::Rect(150, 100, 7, 7)) = 255;
  Darken({100, 105, 60, 10}, 0.4);
  EXPECT_EQ(cv::countNonZero(FindCastShadows(picture_, speck, 60)), 0);
  cv::Mat1b all(kSize, uint8_t{255}), corner(kSize, uint8_t{0});
  EXPECT_EQ(cv::countNonZero(FindCastShadows(picture_, all, 60)), 0);
  corner(cv::Rect(290, 190, 10, 10)) = 255;
  EXPECT_EQ(cv::countNonZero(FindCastShadows(picture_, corner, 60)), 0);
}

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

TEST(RunLengths, GoDownTheColumnsAndBeginWithZeros) {
  const cv::Mat1b corner = (cv::Mat1b(2, 3) << 0, 1, 0,  //
                            0, 255, 7);
  EXPECT_THAT(RunLengths(corner), ElementsAre(2, 2, 1, 1));
  EXPECT_THAT(RunLengths(cv::Mat1b(2, 2, uint8_t{9})), ElementsAre(0, 4));
  EXPECT_THAT(RunLengths(cv::Mat1b(2, 2, uint8_t{0})), ElementsAre(4));
}

// By hand from (RU2), and what COCO's annotations have for these runs. 40 = 8 + 32: two groups;
// 5 - 40 = -35 = 29 - 64: 29 and then -2 in five bits, 30; 21 - 5 = 16 needs a group for its sign.
TEST(RunLengthText, IsCocos) {
  EXPECT_EQ(RunLengthText({6, 1, 40, 4, 5, 4, 5, 4, 21}), "61X13mN000`0");
  EXPECT_EQ(RunLengthText({0, 4}), "04");
  EXPECT_EQ(RunLengthText({15, 16, 31, 32}), "?`0o0`0");
}

}  // namespace
}  // namespace egosieve::tools
