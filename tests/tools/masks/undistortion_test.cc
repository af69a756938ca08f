// Masks of undistorted pictures, against OpenCV's undistortion of the original masks.
#include <filesystem>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "tests/tools/masks/masks_test.h"
#include "tests/tools/testing/outcome.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

class Undistortion : public MasksTest {
 protected:
  void SetUp() override {
    MasksTest::SetUp();
    run_.emplace(WriteFakeRun(root_ + "/drive"));  // six pictures of 96 x 64 pixels
    WriteModel("sparse", "OPENCV 96 64 60 65 49 31 -0.2 0.05 0.01 -0.02");
    WriteModel("dense/sparse", "PINHOLE 110 70 55 57 53.5 36.5");
  }

  // A model of frames 1 to 5.
  void WriteModel(const std::string& folder, const std::string& camera) const {
    fs::create_directories(root_ + "/" + folder);
    std::string images;
    for (int i = 1; i < 6; ++i) {
      absl::StrAppendFormat(&images, "%d 1 0 0 0 0 0 0 7 %06d.png\n\n", i, i);
    }
    WriteText(folder + "/cameras.txt", "7 " + camera + "\n");
    WriteText(folder + "/images.txt", images);
  }
  void WriteText(const std::string& name, const std::string& text) const {
    ASSERT_TRUE(WriteFileAtomically(root_ + "/" + name, text).ok());
  }

  CommandOutcome Undistorted(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {run_->folder.path(), "--undistort=" + root_ + "/dense",
                                          "--sparse=" + root_ + "/sparse"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Masks(arguments);
  }

  // By OpenCV, whose first pixel has its centre at (0, 0); `outside` beyond the picture.
  cv::Mat ByOpenCv(const cv::Mat& from, const cv::Scalar& outside) const {
    cv::Mat map_x, map_y, to;
    cv::initUndistortRectifyMap(cv::Matx33d(60, 0, 48.5, 0, 65, 30.5, 0, 0, 1),
                                cv::Vec4d(-0.2, 0.05, 0.01, -0.02), cv::noArray(),
                                cv::Matx33d(55, 0, 53, 0, 57, 36, 0, 0, 1), cv::Size(110, 70),
                                CV_32FC1, map_x, map_y);
    cv::remap(from, to, map_x, map_y, cv::INTER_NEAREST, cv::BORDER_CONSTANT, outside);
    return to;
  }

  std::optional<FakeRun> run_;
};

TEST_F(Undistortion, IsOpenCvs) {
  ASSERT_THAT(Undistorted({"--for=colmap"}), Succeeds());
  EXPECT_FALSE(fs::exists(out_ + "/000000.png.png"));
  for (int i = 1; i < 6; ++i) {
    const cv::Mat expected = ByOpenCv(Made(*run_, "masks", i) == 0, 0);
    const cv::Mat mask = Read(absl::StrFormat("%06d.png.png", i));
    ASSERT_EQ(mask.size(), cv::Size(110, 70));
    EXPECT_EQ(Differences(mask, expected), 0) << i;
    EXPECT_EQ(mask.at<uint8_t>(0, 0), 0);  // what the picture does not show is masked
  }
  EXPECT_GT(cv::countNonZero(ByOpenCv(Made(*run_, "masks", 3), 0)), 50);
  out_ = root_ + "/inverted";
  ASSERT_THAT(Undistorted({"--for=plain", "--invert"}), Succeeds());
  EXPECT_EQ(Differences(Read("000003.png"), ByOpenCv(Made(*run_, "masks", 3) == 0, 0)), 0);
  out_ = root_ + "/numbers";
  ASSERT_THAT(Undistorted({"--for=mots"}), Succeeds());
  const cv::Mat ids = ByOpenCv(Made(*run_, "ids", 3), 0);
  EXPECT_EQ(Differences(Read("drive/000003.png") != 0, ids != 0), 0);
}

// So does a pinhole that is the original camera, and any camera that stays the same.
TEST_F(Undistortion, OfTheSameCameraIsTheMaskItself) {
  for (const auto& [original, undistorted] :
       {std::pair("SIMPLE_PINHOLE 96 64 60 48 32", "PINHOLE 96 64 60 60 48 32"),
        std::pair("FISHEYE 96 64 60 65 48 32", "FISHEYE 96 64 60 65 48 32")}) {
    WriteModel("sparse", original);
    WriteModel("dense/sparse", undistorted);
    ASSERT_THAT(Undistorted({"--for=plain", "--overwrite"}), Succeeds());
    for (int i = 1; i < 6; ++i) {
      EXPECT_EQ(Differences(Read(absl::StrFormat("%06d.png", i)), Made(*run_, "masks", i)), 0) << i;
    }
  }
}

TEST_F(Undistortion, GivesGaussianSplattingTheUndistortedPicture) {
  EXPECT_THAT(Undistorted({"--for=gaussian-splatting"}),
              EndsWithLine(3, "dense/images/000001.png is missing"));
  EXPECT_FALSE(fs::exists(out_));
  fs::create_directories(root_ + "/dense/images");
  const cv::Mat3b shown(70, 110, cv::Vec3b(10, 20, 30));
  for (int i = 1; i < 6; ++i) {
    cv::imwrite(absl::StrFormat("%s/dense/images/%06d.png", root_, i), shown);
  }
  ASSERT_THAT(Undistorted({"--for=gaussian-splatting"}), Succeeds());
  cv::Mat channels[4];
  cv::split(Read("000003.png"), channels);
  EXPECT_EQ(Differences(channels[3], ByOpenCv(Made(*run_, "masks", 3) == 0, 0)), 0);
  EXPECT_EQ(cv::countNonZero(channels[1] != 20), 0);
}

// One clear line, and nothing is written.
TEST_F(Undistortion, SaysWhatIsWrong) {
  const std::string run = run_->folder.path();
  EXPECT_THAT(Masks({run, "--undistort=" + root_ + "/dense"}), EndsWithLine(2, "belong together"));
  EXPECT_THAT(Undistorted({"--frames=" + root_ + "/f"}), EndsWithLine(2, "original pictures"));
  EXPECT_THAT(Undistorted({"--for=nerfstudio"}), EndsWithLine(2, "leave --undistort out"));
  struct Case {
    const char *sparse, *dense, *message;
    int code;
  };
  const char* const kPinhole = "PINHOLE 110 70 55 57 53.5 36.5";
  for (const Case& bad :
       {Case{"FOV 96 64 60 60 48 32 0.9", kPinhole,
             "the distortion of the model FOV cannot be undone", 2},
        Case{"SIMPLE_PINHOLE 95 64 60 48 32", kPinhole, "has 96 x 64 pixels, its camera in", 2},
        Case{"SIMPLE_PINHOLE 96 64 60 48 32", "SIMPLE_RADIAL 96 64 60 48 32 0.1",
             "its camera 7 has distortion", 2},
        Case{"SIMPLE_PINHOLE 96 64 60 48 32", "PINHOLE 4000000000 4000000000 60 60 48 32",
             "more than a picture", 2},
        Case{"MAGIC 96 64 60 48 32", kPinhole, "the model MAGIC is not known", 3}}) {
    WriteModel("sparse", bad.sparse);
    WriteModel("dense/sparse", bad.dense);
    // Frame 0 is the first picture, whose size is compared before anything is written.
    WriteText("sparse/images.txt",
              *ReadFile(root_ + "/sparse/images.txt") + "9 1 0 0 0 0 0 0 7 000000.png\n\n");
    WriteText("dense/sparse/images.txt", *ReadFile(root_ + "/sparse/images.txt"));
    EXPECT_THAT(Undistorted({"--for=colmap"}), EndsWithLine(bad.code, bad.message));
  }
  WriteModel("sparse", "SIMPLE_PINHOLE 96 64 60 48 32");
  WriteModel("dense/sparse", kPinhole);
  WriteText("dense/sparse/images.txt", "1 1 0 0 0 0 0 0 7 other.jpg\n\n");
  EXPECT_THAT(Undistorted({"--for=colmap"}), EndsWithLine(2, "no image of"));
  WriteText("sparse/images.txt", "1 1 0 0 0 0 0 0 7 other.jpg\n\n");
  EXPECT_THAT(Undistorted({"--for=colmap"}), EndsWithLine(2, "no picture of the input is in"));
  fs::remove(root_ + "/dense/sparse/images.txt");
  EXPECT_THAT(Undistorted({"--for=colmap"}), EndsWithLine(3, "dense holds no model of COLMAP"));
  EXPECT_FALSE(fs::exists(out_));
  out_ = root_ + "/dense/images/masks";
  fs::create_directories(root_ + "/dense/images");
  EXPECT_THAT(Undistorted({"--for=colmap"}), EndsWithLine(2, "lies in what is read"));
}

}  // namespace
}  // namespace egosieve::tools
