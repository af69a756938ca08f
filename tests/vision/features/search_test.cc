#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "tests/vision/features/textured_image.h"
#include "vision/features/flow_patch.h"
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
  return SearchFlow(SearchPyramid(first, options.finest_level),
                    SearchPyramid(second, options.finest_level), options);
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

// Brightness is no displacement.
TEST(FlowPatch, AlignsBetweenPixels) {
  cv::Mat first;
  cv::GaussianBlur(TexturedImage(320, 200, 1), first, {}, 1.5);
  const cv::Mat second = Shifted(first, 1.3, -0.8) + 20.0;
  const FlowPicture from(first), to(second);
  for (const cv::Point2f corner : {cv::Point2f(40.0f, 60.0f), {120.5f, 80.25f}, {200.0f, 150.0f}}) {
    const FlowPatch patch(from, corner);
    const AlignedFlowPatch aligned = patch.Align(to, corner, 10);
    EXPECT_LT(cv::norm(aligned.corner - corner - cv::Point2f(1.3f, -0.8f)), 0.15) << corner;
    EXPECT_GT(patch.Correlation(to, aligned.corner), 0.98f);
    EXPECT_LT(aligned.match.error, 0.2f * patch.Compare(to, corner).error);
    EXPECT_FLOAT_EQ(patch.Correlation(from, corner), 1.0f);
  }
}

// The slope of (PC3) is half the error's derivative by the displacement, up to the difference
// between the gradients of both pictures.
TEST(FlowPatch, SlopeIsTheErrorsDerivative) {
  cv::Mat first;
  cv::GaussianBlur(TexturedImage(320, 200, 1), first, {}, 3.0);
  const FlowPicture picture(first);
  const cv::Point2f corner(100.0f, 80.0f), away(0.5f, 0.25f);
  const FlowPatch patch(picture, corner);
  const auto error = [&](float x, float y) {
    return patch.Compare(picture, corner + away + cv::Point2f(x, y)).error;
  };
  const cv::Point2f slope = patch.Compare(picture, corner + away).slope;
  EXPECT_NEAR(slope.x, 0.5f * (error(0.25f, 0.0f) - error(-0.25f, 0.0f)) / 0.5f,
              0.2f * cv::norm(slope));
  EXPECT_NEAR(slope.y, 0.5f * (error(0.0f, 0.25f) - error(0.0f, -0.25f)) / 0.5f,
              0.2f * cv::norm(slope));
}

TEST(FlowPatch, BlankPatchesHaveNoCorrelation) {
  const cv::Mat blank(64, 64, CV_8U, cv::Scalar(90));
  const FlowPicture from(blank), to(TexturedImage(64, 64, 1));
  const FlowPatch patch(from, {10.0f, 10.0f});
  EXPECT_EQ(patch.Correlation(to, {10.0f, 10.0f}), 0.0f);
  EXPECT_EQ(patch.Align(to, {10.0f, 10.0f}, 5).corner, cv::Point2f(10.0f, 10.0f));
  EXPECT_TRUE(
      std::isfinite(FlowPatch(to, {std::nanf(""), 1e9f}).Compare(from, {-1e9f, 1e9f}).error));
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
  const SearchPyramid pyramid(TexturedImage(1242, 375, 1), 1);
  ASSERT_EQ(pyramid.levels().size(), 5u);
  EXPECT_EQ(pyramid.levels().front().grey.size(), cv::Size(621, 187));
  EXPECT_EQ(pyramid.levels().back().grey.size(), cv::Size(38, 11));
  EXPECT_EQ(SearchPyramid(TexturedImage(16, 16, 1), 2).finest_level(), 0);
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
  for (const auto& there : SearchPatches(FlowPicture(from), FlowPicture(to), places, kSpacing)) {
    count += there.has_value();
  }
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
    const auto found =
        SearchPatches(FlowPicture(pictures.from), FlowPicture(pictures.to), places, kSpacing);
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
    const auto found =
        SearchPatches(FlowPicture(pictures.from), FlowPicture(pictures.to), places, kSpacing);
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
