#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "tests/vision/features/textured_image.h"
#include "vision/features/inverse_search.h"
#include "vision/features/patch_search.h"

namespace egosieve::vision {
namespace {

using testing::TexturedImage;

cv::Mat Shifted(const cv::Mat& image, double x, double y) {
  const cv::Mat map = (cv::Mat_<double>(2, 3) << 1, 0, x, 0, 1, y);
  cv::Mat result;
  cv::warpAffine(image, result, map, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return result;
}

cv::Mat2f FlowBetween(const cv::Mat& first, const cv::Mat& second,
                      const InverseSearchOptions& options) {
  return SearchFlow(SearchPyramid(first, options), SearchPyramid(second, options), options);
}

// The share of the pixels inside that move by (x, y), to a fraction of a pixel.
double ShareNear(const cv::Mat2f& flow, cv::Rect inside, double x, double y, double most) {
  int near = 0;
  for (int row = inside.y; row < inside.br().y; ++row) {
    for (int column = inside.x; column < inside.br().x; ++column) {
      const cv::Vec2f& f = flow(row, column);
      near += std::hypot(f[0] - x, f[1] - y) < most;
    }
  }
  return static_cast<double>(near) / inside.area();
}

TEST(SearchFlow, RecoversShiftsBetweenPixels) {
  const cv::Mat first = TexturedImage(320, 200, 1);
  const cv::Rect inside(24, 24, 272, 152);
  const struct { double x, y; } shifts[] = {{0.0, 0.0}, {0.4, -0.3}, {-6.7, 3.2}, {17.5, 0.0}};
  for (const auto& shift : shifts) {
    const cv::Mat second = Shifted(first, shift.x, shift.y);
    for (const int refinements : {0, 2}) {
      const cv::Mat2f flow = FlowBetween(first, second, {.refinements = refinements});
      ASSERT_EQ(flow.size(), first.size());
      EXPECT_GT(ShareNear(flow, inside, shift.x, shift.y, 0.25), 0.97)
          << shift.x << ", " << shift.y << " with " << refinements << " refinements";
    }
  }
}

// A neighbour's displacement counts only where it fits better.
TEST(SearchFlow, KeepsTwoMotionsApart) {
  const cv::Mat first = TexturedImage(320, 200, 1);
  cv::Mat moved = first.clone();
  const cv::Rect mover(120, 60, 80, 80);
  first(mover).copyTo(moved(mover + cv::Point(9, 0)));
  const cv::Mat2f flow = FlowBetween(first, moved, {});
  EXPECT_GT(ShareNear(flow, {132, 72, 56, 56}, 9.0, 0.0, 0.5), 0.9);
  EXPECT_GT(ShareNear(flow, {20, 20, 80, 160}, 0.0, 0.0, 0.5), 0.97);
}

// Brightness is no displacement.
TEST(SearchFlow, IgnoresAStepOfBrightness) {
  const cv::Mat first = TexturedImage(320, 200, 1);
  cv::Mat second = Shifted(first, 3.0, 1.0);
  second = 0.8 * second + 30.0;
  cv::Mat darker = 0.8 * first;
  const cv::Mat2f flow = FlowBetween(darker, second, {.refinements = 0});
  EXPECT_GT(ShareNear(flow, {24, 24, 272, 152}, 3.0, 1.0, 0.3), 0.95);
}

TEST(SearchFlow, TakesSmallAndBlankPictures) {
  for (const cv::Size size : {cv::Size(16, 16), cv::Size(17, 300), cv::Size(640, 16)}) {
    for (const int finest_level : {0, 1, 2}) {
      const cv::Mat blank(size, CV_8U, cv::Scalar(128));
      const cv::Mat2f still = FlowBetween(blank, blank, {.finest_level = finest_level});
      ASSERT_EQ(still.size(), size);
      EXPECT_EQ(cv::norm(still, cv::NORM_INF), 0.0);
      const cv::Mat noise = TexturedImage(size.width, size.height, 3);
      const cv::Mat2f flow = FlowBetween(noise, blank, {.finest_level = finest_level});
      EXPECT_TRUE(cv::checkRange(flow)) << size << " from level " << finest_level;
    }
  }
}

// A scene whose parts move apart, in noise, and out of the picture.
cv::Mat Rearranged(const cv::Mat& first) {
  cv::Mat second = Shifted(first, 5.3, -2.6);
  cv::Mat part;
  cv::resize(first({100, 40, 60, 60}), part, {72, 72}, 0.0, 0.0, cv::INTER_CUBIC);
  part.copyTo(second({140, 60, 72, 72}));
  cv::Mat noise(second.size(), CV_8U);
  cv::RNG(7).fill(noise, cv::RNG::UNIFORM, 0, 12);
  second(cv::Rect(0, 0, 30, second.rows)).setTo(90);
  return second + noise;
}

TEST(SearchFlow, IsThatOfOpenCv) {
  for (const cv::Size size : {cv::Size(321, 203), cv::Size(640, 194)}) {
    const cv::Mat first = TexturedImage(size.width, size.height, 1), second = Rearranged(first);
    const struct {
      int preset;
      InverseSearchOptions options;
    } cases[] = {
        {cv::DISOpticalFlow::PRESET_MEDIUM, {}},
        {cv::DISOpticalFlow::PRESET_FAST, {.finest_level = 2, .patch_stride = 4, .most_steps = 8}},
        {cv::DISOpticalFlow::PRESET_ULTRAFAST,
         {.finest_level = 2, .patch_stride = 4, .most_steps = 6, .refinements = 0}}};
    for (const auto& [preset, options] : cases) {
      const auto peer = cv::DISOpticalFlow::create(preset);
      peer->setVariationalRefinementIterations(options.refinements);
#if CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 10
      peer->setVariationalRefinementEpsilon(0.001F);  // fixed before; its default has become 0.01
#endif
      cv::Mat expected;
      peer->calc(first, second, expected);
      const cv::Mat flow = FlowBetween(first, second, options);
      int same = 0, near = 0;
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
          const cv::Vec2f apart = flow.at<cv::Vec2f>(y, x) - expected.at<cv::Vec2f>(y, x);
          same += apart == cv::Vec2f(0.0f, 0.0f);
          near += cv::norm(apart) < 0.01;
        }
      }
      EXPECT_GT(near, 0.99 * size.area()) << "preset " << preset;
#if defined(__x86_64__) && CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR == 6
      EXPECT_EQ(same, size.area()) << "preset " << preset;
#endif
    }
  }
}

TEST(SearchFlow, HoldsUpToTheBorder) {
  const cv::Mat first = TexturedImage(320, 200, 1);
  const cv::Mat2f flow = FlowBetween(first, Shifted(first, 0.4, -0.3), {});
  EXPECT_GT(ShareNear(flow, {0, 0, 320, 200}, 0.4, -0.3, 0.25), 0.97);
}

TEST(SearchFlow, TakesLargePictures) {
  const cv::Mat small = TexturedImage(960, 540, 1);
  cv::Mat first;
  cv::resize(small, first, {3840, 2160}, 0.0, 0.0, cv::INTER_CUBIC);
  const cv::Mat2f flow =
      FlowBetween(first, Shifted(first, 42.0, -23.0), {.finest_level = 2, .refinements = 0});
  ASSERT_EQ(flow.size(), first.size());
  EXPECT_GT(ShareNear(flow, {200, 200, 3440, 1760}, 42.0, -23.0, 1.0), 0.97);
}

TEST(SearchPyramid, LevelsHalveDownToAPatch) {
  const SearchPyramid pyramid(TexturedImage(1242, 375, 1), {});
  ASSERT_EQ(pyramid.levels().size(), 5u);
  EXPECT_EQ(pyramid.levels().front().grey.size(), cv::Size(621, 187));
  EXPECT_EQ(pyramid.levels().back().grey.size(), cv::Size(38, 11));
  EXPECT_EQ(SearchPyramid(TexturedImage(16, 16, 1), {.finest_level = 2}).finest_level(), 0);
}

constexpr int kSpacing = 5, kPatchSize = 44;
constexpr int kInside = 10;  // what is seen around a place is of the patch

struct Pictures {
  cv::Mat from = TexturedImage(400, 240, 1), to = TexturedImage(400, 240, 1);

  // A patch of other texture that moves over the background.
  void AddPatch(cv::Point corner, cv::Point2f way, uint64_t seed) {
    const cv::Mat texture = TexturedImage(kPatchSize, kPatchSize, seed);
    const auto put = [&](cv::Mat& picture, cv::Point2f at) {
      const cv::Mat motion = (cv::Mat_<double>(2, 3) << 1, 0, at.x, 0, 1, at.y);
      cv::warpAffine(texture, picture, motion, picture.size(), cv::INTER_CUBIC,
                     cv::BORDER_TRANSPARENT);
    };
    put(from, corner);
    put(to, cv::Point2f(corner) + way);
  }
};

std::vector<cv::Point2f> PlacesIn(const cv::Rect& area) {
  std::vector<cv::Point2f> places;
  for (int y = area.y; y < area.br().y; y += kSpacing) {
    for (int x = area.x; x < area.br().x; x += kSpacing) places.emplace_back(x, y);
  }
  return places;
}

std::vector<cv::Point2f> PlacesOfPatch(cv::Point corner) {
  const int side = kPatchSize - 2 * kInside;
  return PlacesIn({corner.x + kInside, corner.y + kInside, side, side});
}

int CountFound(const cv::Mat& from, const cv::Mat& to, const std::vector<cv::Point2f>& places) {
  int count = 0;
  for (const auto& there : SearchPatches(from, to, places, kSpacing)) count += there.has_value();
  return count;
}

TEST(SearchPatches, FindsWhatIsSmallAndFast) {
  const cv::Point corner(170, 100);
  for (const cv::Point2f way : {cv::Point2f(40.0f, 16.0f),
                                {-39.6f, -15.3f},
                                {33.4f, -9.5f},
                                {-12.7f, 15.6f},
                                {0.0f, -16.0f}}) {
    Pictures pictures;
    pictures.AddPatch(corner, way, 2);
    const std::vector<cv::Point2f> places = PlacesOfPatch(corner);
    const auto found = SearchPatches(pictures.from, pictures.to, places, kSpacing);
    ASSERT_EQ(found.size(), places.size());
    size_t count = 0;
    for (size_t i = 0; i < places.size(); ++i) {
      if (!found[i]) continue;
      ++count;
      EXPECT_LT(cv::norm(*found[i] - places[i] - way), 0.3) << way << " at " << places[i];
    }
    EXPECT_GT(count, 0.8 * places.size()) << way;
  }
}

TEST(SearchPatches, BlankAndRepetitiveTextureHasNoPlace) {
  const std::vector<cv::Point2f> places = PlacesIn({100, 60, 200, 120});
  const cv::Mat blank(240, 400, CV_8UC1, cv::Scalar(120));
  EXPECT_EQ(CountFound(blank, blank, places), 0);
  const auto periodic = [](double x0, double y0) {
    cv::Mat1b picture(240, 400);
    for (int y = 0; y < picture.rows; ++y) {
      for (int x = 0; x < picture.cols; ++x) {
        constexpr double kWave = 2.0 * CV_PI / 20.0;
        picture(y, x) = cv::saturate_cast<uint8_t>(120.0 + 50.0 * std::sin(kWave * (x - x0)) +
                                                   50.0 * std::sin(kWave * (y - y0)));
      }
    }
    return picture;
  };
  cv::RNG random(5);
  const auto with_noise = [&](cv::Mat1b picture, double levels) {
    cv::Mat1s noisy;
    cv::Mat1s noise(picture.size());
    random.fill(noise, cv::RNG::NORMAL, 0.0, levels);
    cv::add(picture, noise, noisy, cv::noArray(), CV_16S);
    noisy.convertTo(picture, CV_8U);
    return picture;
  };
  for (const double levels : {0.0, 0.5, 1.0}) {
    EXPECT_EQ(
        CountFound(with_noise(periodic(0, 0), levels), with_noise(periodic(6, 4), levels), places),
        0)
        << levels;
  }
}

TEST(SearchPatches, WhatLeavesThePictureHasNoPlace) {
  for (const cv::Point corner : {cv::Point(170, -6), {170, 240 - kPatchSize + 6}}) {
    Pictures pictures;
    const float way = corner.y < 0 ? -40.0f : 40.0f;
    pictures.AddPatch(corner, {10.0f, way}, 2);
    EXPECT_EQ(CountFound(pictures.from, pictures.to, PlacesOfPatch(corner)), 0) << corner;
  }
  const Pictures still;
  EXPECT_EQ(CountFound(still.from, still.to, {{-4, 100}, {200, -4}, {200, 239}, {399, 239}}), 0);
}

// The reach sideways ends at the picture's edge.
TEST(SearchPatches, FindsWhatLiesNearTheSides) {
  for (const auto& [corner, way] : {std::pair(cv::Point(4, 100), cv::Point2f(30.0f, 6.0f)),
                                    {{400 - kPatchSize - 4, 100}, {-30.0f, 6.0f}}}) {
    Pictures pictures;
    pictures.AddPatch(corner, way, 2);
    const std::vector<cv::Point2f> places = PlacesOfPatch(corner);
    const auto found = SearchPatches(pictures.from, pictures.to, places, kSpacing);
    size_t count = 0;
    for (size_t i = 0; i < places.size(); ++i) {
      count += found[i] && cv::norm(*found[i] - places[i] - way) < 0.3;
    }
    EXPECT_GT(count, 0.8 * places.size()) << corner;
  }
}

TEST(SearchPatches, OneAloneIsNotBelieved) {
  const cv::Point corner(170, 100);
  Pictures pictures;
  pictures.AddPatch(corner, {30.0f, 8.0f}, 2);
  const std::vector<cv::Point2f> places = PlacesOfPatch(corner);
  ASSERT_GT(CountFound(pictures.from, pictures.to, places), 10);
  for (const cv::Point2f place : places) {
    EXPECT_EQ(CountFound(pictures.from, pictures.to, {place}), 0) << place;
  }
  EXPECT_EQ(CountFound(pictures.from, pictures.to, {}), 0);
}

}  // namespace
}  // namespace egosieve::vision
