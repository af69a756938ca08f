#include "vision/masks/mover_links.h"

#include <map>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/testing/status.h"

namespace egosieve::vision {
namespace {

constexpr int kRed = 7, kBlue = 500;

Sighting Seen(int number, int t, cv::Point2d centre, cv::Point2d speed, int colour = kRed) {
  Sighting sighting{.number = static_cast<uint16_t>(number), .time_seconds = 0.1 * t};
  sighting.centre = centre;
  sighting.pixels = 400.0;
  sighting.arriving = sighting.leaving = speed;
  sighting.colours[colour] = 1.0;
  return sighting;
}

// Frames 0 to `last`; `seen` by frame.
std::vector<SightedFrame> FramesOf(int last, const std::vector<Sighting>& seen,
                                   cv::Point2d shift = {}) {
  std::vector<SightedFrame> frames;
  for (int t = 0; t <= last; ++t) frames.push_back({0.1 * t, t > 0 ? shift : cv::Point2d(), {}});
  for (const Sighting& sighting : seen) {
    frames[cvRound(10.0 * sighting.time_seconds)].sightings.push_back(sighting);
  }
  return frames;
}

// Number 1 in frames 0 to 2, number 2 from frame 3 + gap on, both of what moves at 50 pixels a
// second.
std::vector<Sighting> HiddenFor(int gap, int colour = kRed, double jump = 0.0) {
  std::vector<Sighting> seen;
  for (int t = 0; t < 3; ++t) seen.push_back(Seen(1, t, {20.0 + 5 * t, 50.0}, {50.0, 0.0}));
  for (int t = 3 + gap; t < 6 + gap; ++t) {
    seen.push_back(Seen(2, t, {20.0 + 5 * t, 50.0 + jump}, {50.0, 0.0}, colour));
  }
  return seen;
}

bool AreOneMover(const std::vector<Sighting>& seen, cv::Point2d shift = {}) {
  MoverLinks links;
  const int last = cvRound(10.0 * seen.back().time_seconds);
  const auto movers = links.Add(FramesOf(last, seen, shift));
  EXPECT_EQ(movers.size(), static_cast<size_t>(last + 1));
  return movers[0].at(1) == movers.back().at(2);
}

TEST(MoverLinks, WhatWasHiddenForAShortTimeIsTheSame) {
  EXPECT_TRUE(AreOneMover(HiddenFor(0)));
  EXPECT_TRUE(AreOneMover(HiddenFor(10)));
  EXPECT_FALSE(AreOneMover(HiddenFor(20)));          // for longer than 1.5 s
  EXPECT_FALSE(AreOneMover(HiddenFor(5, kBlue)));    // of another colour
  EXPECT_FALSE(AreOneMover(HiddenFor(5, kRed, 90)))  // elsewhere
      << "a mover of 20 x 20 pixels jumps by 90";
}

TEST(MoverLinks, ACameraThatTurnsMovesNothing) {
  // All places move by 30 pixels a frame with the picture.
  const cv::Point2d shift(-30.0, 4.0);
  std::vector<Sighting> seen = HiddenFor(10);
  EXPECT_FALSE(AreOneMover(seen, shift));
  for (Sighting& sighting : seen) sighting.centre += shift * (10.0 * sighting.time_seconds);
  EXPECT_TRUE(AreOneMover(seen, shift));
}

TEST(MoverLinks, NumbersThatStopWhereTwoCrossGoOnWithTheirSpeeds) {
  // Two of one colour meet in frame 5 and are seen again, with new numbers, from frame 8 on.
  const auto right = [](int t) { return cv::Point2d(20.0 + 8 * t, 50.0); };
  const auto left = [](int t) { return cv::Point2d(124.0 - 8 * t, 50.0); };
  std::vector<Sighting> seen;
  for (int t = 0; t < 5; ++t) {
    seen.push_back(Seen(1, t, right(t), {80.0, 0.0}));
    seen.push_back(Seen(2, t, left(t), {-80.0, 0.0}));
  }
  for (int t = 8; t < 12; ++t) {
    seen.push_back(Seen(3, t, left(t), {-80.0, 0.0}));
    seen.push_back(Seen(4, t, right(t), {80.0, 0.0}));
  }
  MoverLinks links;
  const auto movers = links.Add(FramesOf(11, seen));
  EXPECT_EQ(movers[11].at(4), movers[0].at(1));
  EXPECT_EQ(movers[11].at(3), movers[0].at(2));
  EXPECT_NE(movers[0].at(1), movers[0].at(2));
}

TEST(MoverLinks, OneMoverIsFollowedByOneAtMost) {
  std::vector<Sighting> seen = HiddenFor(2);
  for (int t = 5; t < 8; ++t) seen.push_back(Seen(3, t, {20.0 + 5 * t, 53.0}, {50.0, 0.0}));
  MoverLinks links;
  const auto movers = links.Add(FramesOf(7, seen));
  EXPECT_EQ(movers[7].at(2), movers[0].at(1));  // the nearer one
  EXPECT_NE(movers[7].at(3), movers[0].at(1));
}

TEST(MoverLinks, WhatIsHiddenGoesOnWithItsSpeed) {
  std::vector<Sighting> seen = HiddenFor(10);
  // Another appears with it, where the first was last seen.
  for (int t = 13; t < 16; ++t) seen.push_back(Seen(3, t, {30.0, 50.0}, {50.0, 0.0}));
  MoverLinks links;
  const auto movers = links.Add(FramesOf(15, seen));
  EXPECT_EQ(movers[15].at(2), movers[0].at(1));
  EXPECT_NE(movers[15].at(3), movers[0].at(1));
}

TEST(MoverLinks, GoesOnOverChunksAndAfterRestore) {
  const std::vector<SightedFrame> frames = FramesOf(15, HiddenFor(10));
  for (const int chunk : {1, 2, 5}) {
    MoverLinks whole, restored;
    std::map<uint16_t, uint16_t> first, last;
    for (int t = 0; t < 16; t += chunk) {
      const std::vector<SightedFrame> next(frames.begin() + t,
                                           frames.begin() + std::min(t + chunk, 16));
      restored = Value(MoverLinks::Restore(restored.ToText()));
      const auto movers = whole.Add(next);
      EXPECT_EQ(restored.Add(next), movers) << t;
      if (t == 0) first = movers.front();
      last = movers.back();
    }
    EXPECT_EQ(last.at(2), first.at(1)) << chunk;
    EXPECT_EQ(restored.ToText(), whole.ToText());
  }
  EXPECT_FALSE(MoverLinks::Restore("{}").ok());
  EXPECT_FALSE(MoverLinks::Restore("not json").ok());
}

TEST(SightingsOf, MeasuresAgainstTheStaticScene) {
  // Everything moves by (2, 1) pixels a frame, the mover by (5, 1).
  const cv::Size size(60, 40);
  const cv::Rect body(20, 10, 12, 8);
  std::vector<TrackedFrame> frames;
  for (int t = 0; t < 2; ++t) {
    TrackedFrame frame{0.5 * t, cv::Mat3b(size, cv::Vec3b(10, 10, 250)), {}};
    if (t > 0) {
      frame.flow = {cv::Mat(size, CV_32FC2, cv::Scalar(2.0, 1.0)),
                    cv::Mat(size, CV_32FC2, cv::Scalar(-2.0, -1.0))};
      frame.flow.forward(body).setTo(cv::Scalar(5.0, 1.0));
      frame.flow.backward(body + cv::Point(5, 1)).setTo(cv::Scalar(-5.0, -1.0));
    }
    frame.errors = ReturnErrorsOf(frame.flow);
    frames.push_back(frame);
  }
  cv::Mat1w numbers = cv::Mat1w::zeros(size);
  numbers(body) = 3;
  const SightedFrame first = SightingsOf(frames, 0, numbers, false);
  ASSERT_EQ(first.sightings.size(), 1u);
  const Sighting& sighting = first.sightings[0];
  EXPECT_EQ(sighting.number, 3);
  EXPECT_EQ(sighting.pixels, 96.0);
  EXPECT_EQ(sighting.centre, cv::Point2d(25.5, 13.5));
  EXPECT_EQ(sighting.colours[ColourOf({10, 10, 250})], 1.0);
  EXPECT_FALSE(sighting.arriving.has_value());
  EXPECT_EQ(sighting.leaving.value(), cv::Point2d(6.0, 0.0));  // 3 pixels in half a second
  EXPECT_FALSE(SightingsOf(frames, 0, numbers, true).sightings[0].leaving.has_value());
  numbers.setTo(0);
  numbers(body + cv::Point(5, 1)) = 3;
  const SightedFrame second = SightingsOf(frames, 1, numbers, true);
  EXPECT_EQ(second.shift, cv::Point2d(2.0, 1.0));
  EXPECT_EQ(second.sightings[0].arriving.value(), cv::Point2d(6.0, 0.0));
  frames[0].time_seconds = frames[1].time_seconds;  // tells no speed
  EXPECT_FALSE(SightingsOf(frames, 1, numbers, true).sightings[0].arriving.has_value());
}

}  // namespace
}  // namespace egosieve::vision
