#include "vision/masks/pixel_assignment.h"

#include <opencv2/imgproc.hpp>

#include "gtest/gtest.h"

namespace egosieve::vision {
namespace {

const cv::Size kSize(120, 60);
const cv::Rect kBack(20, 15, 70, 30), kFront(50, 20, 14, 30);
constexpr int kBackStep = 6, kFrontStep = -6;

cv::Mat3b Texture(uint64_t seed) {
  cv::Mat3b image(kSize);
  cv::RNG random(seed);
  random.fill(image, cv::RNG::UNIFORM, 60, 180);
  cv::GaussianBlur(image, image, {}, 1.2);
  return image;
}

// Two textured bodies, the front one before the other, after t steps; what is whose in `owner`.
cv::Mat3b PictureAt(int t, cv::Mat1w* owner) {
  static const cv::Mat3b back = Texture(1), front = Texture(2);
  cv::Mat3b image(kSize, cv::Vec3b(30, 30, 30));
  *owner = cv::Mat1w::zeros(kSize);
  back(kBack).copyTo(image(kBack + cv::Point(kBackStep * t, 0)));
  (*owner)(kBack + cv::Point(kBackStep * t, 0)) = uint16_t{1};
  front(kFront).copyTo(image(kFront + cv::Point(kFrontStep * t, 0)));
  (*owner)(kFront + cv::Point(kFrontStep * t, 0)) = uint16_t{2};
  return image;
}

// Flow that says nothing: it does not return.
FlowPair NoFlow() {
  return {cv::Mat(kSize, CV_32FC2, cv::Scalar(9.0, 9.0)),
          cv::Mat(kSize, CV_32FC2, cv::Scalar(9.0, 9.0))};
}

KnownMover Moving(uint16_t number, int step, const ColourShares& colours) {
  KnownMover mover{number, {{}, {static_cast<double>(step), 0.0}, cv::Matx22d::zeros()}, &colours};
  return mover;
}

double ShareRight(const cv::Mat1w& numbers, const cv::Mat1w& truth) {
  return static_cast<double>(cv::countNonZero((numbers == truth) & (truth != 0))) /
         cv::countNonZero(truth);
}

TEST(AssignPixels, PicturesTellWhoseAPixelIsWhereFlowSaysNothing) {
  cv::Mat1w last, truth, later;
  AssignmentPictures pictures;
  pictures.before = PictureAt(0, &last);
  pictures.now = PictureAt(1, &truth);
  pictures.from_before = NoFlow();
  pictures.mask = truth != 0;
  const ColourShares colours = {};
  const std::vector<KnownMover> movers = {Moving(1, kBackStep, colours),
                                          Moving(2, kFrontStep, colours)};
  // 12 columns appear from behind the front body: the picture before does not show them, the one
  // after does. They are 12 x 25 of the 2,170 pixels.
  const double without = ShareRight(AssignPixels(pictures, last, movers), truth);
  EXPECT_GT(without, 0.8);
  pictures.after = PictureAt(2, &later);
  pictures.to_after = NoFlow();
  const double with = ShareRight(AssignPixels(pictures, last, movers), truth);
  EXPECT_GT(with, 0.95);
  EXPECT_GT(with, without);
}

TEST(AssignPixels, LeavesPixelsThatNoMoverExplains) {
  cv::Mat1w last, truth;
  AssignmentPictures pictures;
  pictures.before = PictureAt(0, &last);
  pictures.now = PictureAt(1, &truth).clone();
  // Something white with flow of its own appears 20 pixels beside the back body.
  const cv::Rect new_body(112, 20, 8, 20);
  pictures.now(new_body) = cv::Vec3b(255, 255, 255);
  pictures.from_before = {cv::Mat(kSize, CV_32FC2, cv::Scalar(kBackStep, 0.0)),
                          cv::Mat(kSize, CV_32FC2, cv::Scalar(-kBackStep, 0.0))};
  pictures.from_before.backward(new_body).setTo(cv::Scalar(8.0, 0.0));
  pictures.from_before.forward.colRange(112, 120).setTo(cv::Scalar(-8.0, 0.0));
  pictures.mask = (truth != 0);
  pictures.mask(new_body) = 255;
  const ColourShares colours = {};
  const cv::Mat1w numbers = AssignPixels(pictures, last, {Moving(1, kBackStep, colours)});
  EXPECT_EQ(numbers(30, 116), 0);
  EXPECT_EQ(numbers(20, 30), 1);
}

}  // namespace
}  // namespace egosieve::vision
