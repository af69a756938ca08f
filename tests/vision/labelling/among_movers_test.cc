#include "vision/labelling/among_movers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {
namespace {

constexpr int kCell = 5;
const cv::Size kPicture(300, 200);  // kReach: 30 pixels, six cells

// The definition, place by place.
bool IsAmong(const std::vector<cv::Point2f>& places, cv::Point2f place) {
  const auto cell = [](float pixels) { return static_cast<int>(pixels) / kCell; };
  bool quarter[4] = {};
  for (const cv::Point2f& other : places) {
    cv::Point d(cell(other.x) - cell(place.x), cell(other.y) - cell(place.y));
    if (std::abs(d.x) > 6 || std::abs(d.y) > 6) continue;
    for (bool& is_there : quarter) {
      is_there = is_there || (d.x > 0 && d.y >= 0);
      d = {d.y, -d.x};
    }
  }
  return quarter[0] && quarter[1] && quarter[2] && quarter[3];
}

TEST(AmongMovers, HasWhatIsAmongThemAsDefined) {
  cv::RNG random(5);
  for (const int count : {0, 3, 30, 150, 1500}) {
    std::vector<cv::Point2f> places;
    for (int i = 0; i < count; ++i)
      places.emplace_back(random.uniform(0.f, 300.f), random.uniform(0.f, 200.f));
    const AmongMovers among(places, kPicture, kCell);
    int around = 0;
    for (float y = 0.5f; y < 200.f; y += 3.f) {
      for (float x = 0.5f; x < 300.f; x += 3.f) {
        ASSERT_EQ(among.Has({x, y}), IsAmong(places, {x, y})) << count << ' ' << x << ' ' << y;
        around += among.Has({x, y});
      }
    }
    EXPECT_EQ(around > 0, count >= 30) << count;
  }
}

// Of a van only the outline has texture.
TEST(AmongMovers, HasWhatIsBlankWithinAMoverButNotBesideIt) {
  std::vector<cv::Point2f> outline;
  for (float t = 0.f; t <= 40.f; t += 5.f) {
    for (const cv::Point2f& p :
         {cv::Point2f(t, 0.f), cv::Point2f(t, 40.f), cv::Point2f(0.f, t), cv::Point2f(40.f, t)}) {
      outline.push_back(cv::Point2f(100.f, 80.f) + p);
    }
  }
  const AmongMovers among(outline, kPicture, kCell);
  EXPECT_TRUE(among.Has({120.f, 100.f}));
  EXPECT_TRUE(among.Has({107.f, 113.f}));
  for (const cv::Point2f beside :
       {cv::Point2f(120.f, 70.f), cv::Point2f(90.f, 100.f), cv::Point2f(150.f, 100.f),
        cv::Point2f(120.f, 130.f), cv::Point2f(299.f, 199.f)}) {
    EXPECT_FALSE(among.Has(beside)) << beside;
  }
}

}  // namespace
}  // namespace egosieve::vision
