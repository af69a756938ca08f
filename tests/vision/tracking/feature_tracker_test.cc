#include "vision/tracking/feature_tracker.h"

#include <gtest/gtest.h>

#include <random>

namespace egosieve::vision {
namespace {

// Features with random looks; feature i of the scene is at (10 i + t, 5).
FeatureSet Scene(int count, int t, double drift = 0.0) {
  FeatureSet set;
  for (int i = 0; i < count; ++i) {
    std::mt19937_64 random(i + 1), other(i + 1001);
    set.positions.emplace_back(10.0F * i + t, 5.0F);
    for (int k = 0; k < kSiftDescriptorBytes; ++k) {
      const double a = static_cast<double>(random() % 90), b = static_cast<double>(other() % 90);
      set.descriptors.push_back(static_cast<uint8_t>((1 - drift) * a + drift * b));
    }
  }
  return set;
}

std::vector<Match> Identity(int count) {
  std::vector<Match> matches;
  for (int i = 0; i < count; ++i) matches.push_back({i, i, 0.5F});
  return matches;
}

FeatureTracker Tracker(const FeatureTrackerOptions& options = {}) {
  return *FeatureTracker::Create(options);
}

TEST(FeatureTracker, ChainsMatchesWithStableIds) {
  FeatureTracker tracker = Tracker();
  for (int t = 0; t < 40; ++t) {
    ASSERT_TRUE(tracker.Advance(t, Scene(5, t), Identity(5)).ok());
    ASSERT_EQ(tracker.tracks().size(), 5U);
    for (int i = 0; i < 5; ++i) {
      const Track& track = tracker.tracks()[i];
      EXPECT_EQ(track.id, i);
      EXPECT_EQ(track.length, t + 1);
      EXPECT_FALSE(track.Reaches(kTrackHistory));
      for (int k = 0; track.Reaches(k); ++k) {
        EXPECT_EQ(track.places[k], cv::Point2f(10.0F * i + t - k, 5.0F));
      }
      EXPECT_EQ(track.Reaches(kTrackHistory - 1), t >= kTrackHistory - 1);
    }
  }
}

TEST(FeatureTracker, LostTracksEndAndIdsAreNotGivenTwice) {
  FeatureTracker tracker = Tracker();
  ASSERT_TRUE(tracker.Advance(0, Scene(3, 0), {}).ok());
  ASSERT_TRUE(tracker.Advance(1, Scene(3, 1), {{1, 1, 0.0F}}).ok());
  EXPECT_EQ(tracker.tracks()[0].id, 3);
  EXPECT_EQ(tracker.tracks()[1].id, 1);
  EXPECT_EQ(tracker.tracks()[2].id, 4);
  EXPECT_EQ(tracker.tracks()[0].length, 1);
  EXPECT_EQ(tracker.tracks()[1].length, 2);
}

TEST(FeatureTracker, DroppedFrameEndsAllTracks) {
  FeatureTracker tracker = Tracker();
  ASSERT_TRUE(tracker.Advance(0, Scene(3, 0), {}).ok());
  ASSERT_TRUE(tracker.Advance(2, Scene(3, 2), Identity(3)).ok());
  for (const Track& track : tracker.tracks()) {
    EXPECT_EQ(track.length, 1);
    EXPECT_GE(track.id, 3);
  }
}

TEST(FeatureTracker, ChainsOfEveryThirdFrame) {
  FeatureTrackerOptions options;
  options.frame_step = 3;
  FeatureTracker tracker = Tracker(options);
  ASSERT_TRUE(tracker.Advance(1, Scene(3, 0), {}).ok());
  ASSERT_TRUE(tracker.Advance(4, Scene(3, 2), Identity(3)).ok());
  EXPECT_EQ(tracker.tracks()[0].length, 2);
  ASSERT_TRUE(tracker.Advance(5, Scene(3, 2), Identity(3)).ok());
  EXPECT_EQ(tracker.tracks()[0].length, 1);
}

TEST(FeatureTracker, EndAllStartsAnewWithNewIds) {
  FeatureTracker tracker = Tracker();
  ASSERT_TRUE(tracker.Advance(0, Scene(3, 0), {}).ok());
  tracker.EndAll();
  EXPECT_TRUE(tracker.tracks().empty());
  ASSERT_TRUE(tracker.Advance(1, Scene(3, 1), Identity(3)).ok());
  EXPECT_EQ(tracker.tracks()[0].id, 3);
  EXPECT_EQ(tracker.tracks()[0].length, 1);
}

// A chain of matches each of which looks good, and whose end is another thing than its beginning.
TEST(FeatureTracker, DriftFromTheFirstAppearanceEndsTheTrack) {
  FeatureTrackerOptions options;
  options.reference_frames = 100;
  FeatureTracker tracker = Tracker(options);
  const int frames = 11;
  int64_t longest = 0;
  for (int t = 0; t < frames; ++t) {
    ASSERT_TRUE(tracker.Advance(t, Scene(4, t, 0.1 * t), Identity(4)).ok());
    for (const Track& track : tracker.tracks()) longest = std::max(longest, track.length);
  }
  // Unrelated looks are about sqrt(128 x 2 x 26^2) = 416 apart, so the limit lies at 84 % of the
  // way: after 8 or 9 steps.
  EXPECT_LT(longest, frames);
  EXPECT_GE(longest, 6);

  // The same change over a longer time, with the reference renewed, is a look that changes.
  options.reference_frames = 3;
  tracker = Tracker(options);
  for (int t = 0; t < frames; ++t) {
    ASSERT_TRUE(tracker.Advance(t, Scene(4, t, 0.1 * t), Identity(4)).ok());
  }
  EXPECT_EQ(tracker.tracks()[0].length, frames);
}

TEST(FeatureTracker, ErrorsLeaveTheStateUnchanged) {
  FeatureTracker tracker = Tracker();
  ASSERT_TRUE(tracker.Advance(3, Scene(3, 0), {}).ok());
  const FeatureTrackerState before = tracker.state();
  EXPECT_EQ(tracker.Advance(3, Scene(3, 1), {}).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(tracker.Advance(4, Scene(3, 1), {{0, 3, 0.F}}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(tracker.Advance(4, Scene(3, 1), {{-1, 0, 0.F}}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(tracker.Advance(4, Scene(3, 1), {{0, 0, 0.F}, {0, 1, 0.F}}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(tracker.Advance(4, Scene(3, 1), {{0, 1, 0.F}, {2, 1, 0.F}}).code(),
            absl::StatusCode::kInvalidArgument);
  FeatureSet torn = Scene(3, 1);
  torn.descriptors.pop_back();
  EXPECT_EQ(tracker.Advance(4, torn, {}).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(tracker.state().frame_index, before.frame_index);
  EXPECT_EQ(tracker.state().next_id, before.next_id);
  EXPECT_EQ(tracker.tracks().size(), before.tracks.size());
}

TEST(FeatureTracker, RestoredStateGoesOnTheSame) {
  std::mt19937_64 random(11);
  FeatureTracker whole = Tracker(), resumed = Tracker();
  for (int t = 0; t < 30; ++t) {
    std::vector<Match> matches;
    for (int i = 0; i < 20; ++i) {
      if (random() % 4 != 0) matches.push_back({i, i, 0.0F});
    }
    const FeatureSet scene = Scene(20, t, 0.03 * t);
    ASSERT_TRUE(whole.Advance(t, scene, matches).ok());
    FeatureTracker fresh = Tracker();
    ASSERT_TRUE(fresh.Restore(resumed.state()).ok());
    resumed = fresh;
    ASSERT_TRUE(resumed.Advance(t, scene, matches).ok());
    for (int i = 0; i < 20; ++i) {
      const Track &a = whole.tracks()[i], &b = resumed.tracks()[i];
      ASSERT_EQ(a.id, b.id);
      ASSERT_EQ(a.length, b.length);
      for (int k = 0; a.Reaches(k); ++k) ASSERT_EQ(a.places[k], b.places[k]);
    }
  }
}

TEST(FeatureTracker, TornStateIsRefused) {
  FeatureTracker tracker = Tracker();
  ASSERT_TRUE(tracker.Advance(0, Scene(3, 0), {}).ok());
  FeatureTrackerState state = tracker.state();
  state.references.pop_back();
  EXPECT_FALSE(tracker.Restore(state).ok());
  state = tracker.state();
  state.next_id = 1;
  EXPECT_FALSE(tracker.Restore(state).ok());
}

TEST(FeatureTracker, FramesWithoutFeatures) {
  FeatureTracker tracker = Tracker();
  EXPECT_TRUE(tracker.Advance(0, FeatureSet(), {}).ok());
  EXPECT_TRUE(tracker.Advance(1, Scene(2, 1), {}).ok());
  EXPECT_TRUE(tracker.Advance(2, FeatureSet(), {}).ok());
  EXPECT_TRUE(tracker.tracks().empty());
}

TEST(FeatureTracker, OptionsAreChecked) {
  FeatureTrackerOptions options;
  options.max_descriptor_distance = std::nan("");
  EXPECT_FALSE(FeatureTracker::Create(options).ok());
  options = {};
  options.reference_frames = 0;
  EXPECT_FALSE(FeatureTracker::Create(options).ok());
  options = {};
  options.frame_step = 0;
  EXPECT_FALSE(FeatureTracker::Create(options).ok());
}

}  // namespace
}  // namespace egosieve::vision
