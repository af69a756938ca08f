#include "vision/tracking/grid_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace egosieve::vision {
namespace {

const cv::Size kSize(120, 80);

constexpr int kStride = 5;

// x_2 = centre + zoom (x_1 - centre) + shift, at the nodes of the second frame.
std::vector<PointPair> Zoom(double zoom, cv::Point2d shift, cv::Size size = kSize) {
  std::vector<PointPair> links;
  for (int y = kStride / 2; y < size.height; y += kStride) {
    for (int x = kStride / 2; x < size.width; x += kStride) {
      const double u = (x - 60.0 - shift.x) / zoom + 60, v = (y - 40.0 - shift.y) / zoom + 40;
      const bool inside = u >= 0 && v >= 0 && u <= size.width - 1 && v <= size.height - 1;
      if (inside) links.push_back({u, v, static_cast<double>(x), static_cast<double>(y)});
    }
  }
  return links;
}

TEST(GridTracker, PastPlacesFollowTheFlow) {
  const double zoom = 1.03;
  GridTracker tracker(kStride);
  for (int t = 0; t < 20; ++t) {
    tracker.Advance(t, kSize, Zoom(zoom, {0.7, 0.3}));
    ASSERT_EQ(tracker.tracks().size(), 24U * 16U);
    for (const Track& track : tracker.tracks()) {
      cv::Point2d place(track.places[0].x - 60.0, track.places[0].y - 40.0);
      for (int k = 1; track.Reaches(k); ++k) {
        place = (place - cv::Point2d(0.7, 0.3)) / zoom;
        // The field is linear, so bilinear reading is exact but for float's rounding, which adds up
        // over 16 frames; reading beyond the outermost nodes (2 pixels at each side) extends them.
        const bool inner = std::abs(place.x) < 56 && std::abs(place.y) < 36;
        const double tolerance = inner ? 2e-3 : 0.15 * k;
        ASSERT_NEAR(track.places[k].x, place.x + 60, tolerance) << t << " " << k;
        ASSERT_NEAR(track.places[k].y, place.y + 40, tolerance) << t << " " << k;
      }
    }
  }
  int long_lived = 0;
  for (const Track& track : tracker.tracks()) long_lived += track.length == 20 ? 1 : 0;
  // A zoom brings nothing in from outside, but for the shift's margin.
  EXPECT_GT(long_lived, 300);
}

TEST(GridTracker, IdsAreUniqueAndChildrenNameTheirParent) {
  GridTracker tracker(kStride);
  std::set<int64_t> before;
  for (int t = 0; t < 10; ++t) {
    tracker.Advance(t, kSize, Zoom(1.08, {0, 0}));
    std::set<int64_t> ids;
    int kept = 0;
    for (const Track& track : tracker.tracks()) {
      EXPECT_TRUE(ids.insert(track.id).second);
      EXPECT_EQ(track.parent_id >= 0, track.length > 1);
      EXPECT_TRUE(track.parent_id < 0 || before.contains(track.parent_id));
      if (track.id == track.parent_id) ++kept;
      const bool is_new = before.empty() || track.id > *before.rbegin();
      EXPECT_TRUE(is_new || before.contains(track.id));
    }
    EXPECT_TRUE(t == 0 || kept > 250) << kept;
    before = ids;
  }
}

TEST(GridTracker, NodesWithoutALinkAreBorn) {
  GridTracker tracker(kStride);
  tracker.Advance(0, kSize, Zoom(1.0, {0, 0}));
  std::vector<PointPair> links = Zoom(1.0, {1.0, 0.0});
  const auto torn = [](double x, double y) { return x > 50 && x < 80 && y > 30 && y < 60; };
  std::erase_if(links, [&](const PointPair& link) { return torn(link.x2, link.y2); });
  tracker.Advance(1, kSize, links);
  int born = 0;
  for (const Track& track : tracker.tracks()) {
    const cv::Point2f p = track.places[0];
    EXPECT_EQ(track.length, torn(p.x, p.y) ? 1 : 2) << p;
    born += track.length == 1 ? 1 : 0;
  }
  EXPECT_EQ(born, 36);
}

// Left half still, right half moving: no past between the two may be invented. All sways by a
// pixel, so that places lie between the nodes.
TEST(GridTracker, EdgesAreNotBlended) {
  GridTracker tracker(kStride);
  for (int t = 0; t < 5; ++t) {
    const double sway = t % 2 == 0 ? 1.0 : -1.0;
    std::vector<PointPair> links;
    for (const PointPair& link : Zoom(1.0, {0, 0})) {
      const double x = link.x1 + sway, y = link.x2 > 60 ? link.y1 - 6 : link.y1;
      if (y >= 0 && x <= kSize.width - 1) links.push_back({x, y, link.x2, link.y2});
    }
    tracker.Advance(t, kSize, links);
  }
  int moving = 0;
  for (const Track& track : tracker.tracks()) {
    if (!track.Reaches(3)) continue;
    const float moved = track.places[0].y - track.places[3].y;
    EXPECT_TRUE(std::abs(moved) < 1e-3 || std::abs(moved - 18) < 1e-3) << moved;
    moving += moved > 1 ? 1 : 0;
  }
  EXPECT_GT(moving, 100);
}

// A camera that turns: what enters at the left has no past further left.
TEST(GridTracker, APastEndsWhereItLeavesTheImage) {
  constexpr double kShift = 7.3;
  GridTracker tracker(kStride);
  for (int t = 0; t < 12; ++t) {
    tracker.Advance(t, kSize, Zoom(1.0, {kShift, 0}));
    for (const Track& track : tracker.tracks()) {
      const float x = track.places[0].x;
      for (int k = 0; track.Reaches(k); ++k) {
        ASSERT_GE(track.places[k].x, 0.0F);
        ASSERT_NEAR(track.places[k].x, x - kShift * k, 1e-3);
      }
      // What it has in common with the nearest node: of the way to the edge half a node is lost.
      const auto seen = static_cast<int64_t>((x - kStride / 2.0) / kShift);
      ASSERT_GE(track.length, std::min<int64_t>(t, seen));
    }
  }
}

TEST(GridTracker, DroppedFrameCutAndSizeEndAllTracks) {
  GridTracker tracker(kStride);
  const auto all_born = [&] {
    for (const Track& track : tracker.tracks()) {
      if (track.length != 1 || track.parent_id != -1) return false;
    }
    return true;
  };
  tracker.Advance(0, kSize, Zoom(1.0, {0, 0}));
  tracker.Advance(1, kSize, Zoom(1.0, {0, 0}));
  EXPECT_FALSE(all_born());
  tracker.Advance(3, kSize, Zoom(1.0, {0, 0}));
  EXPECT_TRUE(all_born());
  tracker.EndAll();
  tracker.Advance(4, kSize, Zoom(1.0, {0, 0}));
  EXPECT_TRUE(all_born());
  tracker.Advance(5, {60, 60}, Zoom(1.0, {0, 0}, {60, 60}));
  EXPECT_TRUE(all_born());
}

TEST(GridTracker, RestoredStateGoesOnTheSame) {
  GridTracker whole(kStride), resumed(kStride);
  for (int t = 0; t < 20; ++t) {
    const std::vector<PointPair> links = Zoom(1.0 + 0.002 * (t % 5), {0.3 * t, 0.1});
    GridTracker fresh(kStride);
    ASSERT_TRUE(fresh.Restore(resumed.state()).ok());
    resumed = fresh;
    whole.Advance(t, kSize, links);
    resumed.Advance(t, kSize, links);
    for (size_t i = 0; i < whole.tracks().size(); ++i) {
      const Track &a = whole.tracks()[i], &b = resumed.tracks()[i];
      ASSERT_EQ(a.id, b.id);
      ASSERT_EQ(a.length, b.length);
      for (int k = 0; a.Reaches(k); ++k) ASSERT_EQ(a.places[k], b.places[k]);
    }
  }
}

TEST(GridTracker, ATornStateIsRefused) {
  GridTracker tracker(kStride);
  tracker.Advance(2, kSize, Zoom(1.0, {0, 0}));
  GridTrackerState state = tracker.state();
  state.tracks.pop_back();
  EXPECT_FALSE(tracker.Restore(state).ok());
}

}  // namespace
}  // namespace egosieve::vision
