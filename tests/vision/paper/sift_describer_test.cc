#include "vision/paper/sift_describer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <vector>

#include "tests/vision/features/textured_image.h"
#include "vision/paper/feature_set.h"

namespace egosieve::vision {
namespace {

using testing::TexturedImage;

double Cosine(const uint8_t* a, const uint8_t* b) {
  double aa = 0, bb = 0, ab = 0;
  for (int k = 0; k < kSiftDescriptorBytes; ++k) {
    aa += double{1} * a[k] * a[k];
    bb += double{1} * b[k] * b[k];
    ab += double{1} * a[k] * b[k];
  }
  return ab / std::sqrt(aa * bb);
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// OpenCV describes on other levels (its first octave is the doubled image), so that the numbers
// differ; a layout, an orientation or a weight gone wrong makes the cosine fall to that of
// strangers, about 0.6.
TEST(SiftDescriber, AgreesWithOpenCv) {
  const cv::Mat image = TexturedImage(400, 300, 1);
  const auto sift = cv::SIFT::create(800, 3, 0.02, 10, 1.6, CV_8U);
  std::vector<cv::KeyPoint> key_points;
  cv::Mat theirs;
  sift->detectAndCompute(image, cv::noArray(), key_points, theirs);
  std::vector<DescribedPlace> places;
  for (const auto& p : key_points) places.push_back({p.pt, 0.5F * p.size, p.angle});
  std::vector<uint8_t> ours(places.size() * kSiftDescriptorBytes);
  SiftDescriber(image).Describe(places, 2, ours.data());
  std::vector<double> cosines, strangers;
  for (size_t i = 0; i < places.size(); ++i) {
    const uint8_t* mine = &ours[i * kSiftDescriptorBytes];
    cosines.push_back(Cosine(mine, theirs.ptr<uint8_t>(static_cast<int>(i))));
    strangers.push_back(
        Cosine(mine, theirs.ptr<uint8_t>(static_cast<int>((i + 50) % places.size()))));
  }
  ASSERT_GT(cosines.size(), 200u);
  EXPECT_GT(Median(cosines), 0.95);
  EXPECT_LT(Median(strangers), 0.8);
}

// A sample whose cell is so near to the outer border that adding 1 to it rounds up: with the cell's
// width of 3 sigma = 4 samples it lies at 3.99999976. Only the address sanitizer sees what is
// written beyond the histogram.
TEST(SiftDescriber, ASampleAtTheOuterBorderHasABin) {
  const cv::Mat image = TexturedImage(64, 64, 5);
  const float x = 10.0F + std::ldexp(1.0F, -20);
  std::vector<uint8_t> out(kSiftDescriptorBytes);
  SiftDescriber(image).Describe({{{x, 32.0F}, 4.0F / 3.0F, 0.0F}}, 1, out.data());
  EXPECT_GT(*std::max_element(out.begin(), out.end()), 0);
}

// A quarter turn of the image and of the orientation leaves the descriptor as it was.
TEST(SiftDescriber, TurnsWithTheImage) {
  const cv::Mat image = TexturedImage(200, 200, 2);
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);  // (x, y) goes to (199 - y, x)
  const SiftDescriber upright(image), rotated(turned);
  for (const float sigma : {0.8F, 1.5F, 4.0F}) {
    // Sampled levels keep even pixels, which a turn of an even-sided image makes odd ones: only
    // where octave 0 serves is the grid the same.
    const double least = sigma < 1.4F ? 0.999 : 0.9;
    std::vector<uint8_t> a(kSiftDescriptorBytes), b(kSiftDescriptorBytes);
    upright.Describe({{cv::Point2f(90, 110), sigma, 30.0F}}, 1, a.data());
    rotated.Describe({{cv::Point2f(199 - 110, 90), sigma, 120.0F}}, 1, b.data());
    EXPECT_GT(Cosine(a.data(), b.data()), least) << sigma;
  }
}

TEST(SiftDescriber, FlatSurroundingsAndPlacesAtTheBorder) {
  std::vector<uint8_t> bytes(kSiftDescriptorBytes, 1);
  const DescribedPlace corner{cv::Point2f(0, 0), 2.0F, 359.999F};
  for (int grey = 0; grey < 256; ++grey) {
    SiftDescriber(cv::Mat(30, 30, CV_8U, cv::Scalar(grey))).Describe({corner}, 1, bytes.data());
    EXPECT_TRUE(std::all_of(bytes.begin(), bytes.end(), [](uint8_t b) { return b == 0; })) << grey;
  }
  const SiftDescriber tiny(TexturedImage(3, 2, 1));
  for (const float sigma : {0.1F, 1.0F, 30.0F, 1e6F}) {
    for (const float degrees : {-720.0F, -1.0F, 0.0F, 360.0F}) {
      tiny.Describe({{cv::Point2f(2, 1), sigma, degrees}}, 1, bytes.data());
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
