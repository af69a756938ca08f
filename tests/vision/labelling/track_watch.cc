#include "tests/vision/labelling/track_watch.h"

#include <gtest/gtest.h>

namespace egosieve::vision {

void TrackWatch::CheckTracks(const std::vector<Track>& tracks, int64_t next_id, cv::Size size,
                             Ids& ids) {
  ASSERT_GE(next_id, ids.next);
  std::set<int64_t> now;
  for (const Track& track : tracks) {
    ASSERT_TRUE(now.insert(track.id).second) << "track " << track.id << " is there twice";
    ASSERT_LT(track.id, next_id);
    ASSERT_TRUE(track.id >= ids.next || ids.last.contains(track.id))
        << "the id " << track.id << " was given before, and not to a track of the last picture";
    ASSERT_LE(track.length, pictures_);
    ASSERT_EQ(track.parent_id < 0, track.length == 1);
    // Tracks that were born in the picture before have parents that no state has shown.
    ASSERT_TRUE(track.parent_id < 0 || track.length == 2 || ids.last.contains(track.parent_id));
    for (int k = 0; track.Reaches(k); ++k) {
      const cv::Point2f place = track.places[k];
      ASSERT_TRUE(place.x >= 0 && place.y >= 0 && place.x <= static_cast<float>(size.width - 1) &&
                  place.y <= static_cast<float>(size.height - 1))
          << place << ", " << k << " pictures ago";
    }
  }
  ids.last = std::move(now);
  ids.next = next_id;
}

void TrackWatch::Check(const LabelledFrame& labels, const LabellerState& state) {
  SCOPED_TRACE(testing::Message() << "frame " << labels.frame_index);
  const bool goes_on = labels.outcome == LabelOutcome::kLabelled ||
                       labels.outcome == LabelOutcome::kUntrustedMotion ||
                       (labels.outcome == LabelOutcome::kNoPair && labels.match_count > 0);
  if (!goes_on) begin_ = labels.frame_index;
  pictures_ = goes_on ? pictures_ + 1 : 1;
  const EvidenceLabellerState& evidence = state.evidence;
  const cv::Size size = labels.labelled.image.size();
  CheckTracks(evidence.grid.tracks, evidence.grid.next_id, size, grid_);

  const size_t nodes =
      static_cast<size_t>(size.width / FrameLabellerOptions::kFlowStridePixels + 1) *
      (size.height / FrameLabellerOptions::kFlowStridePixels + 1);
  EXPECT_LE(evidence.grid.tracks.size(), nodes);
  EXPECT_LE(evidence.evidence.memories.size(), evidence.grid.tracks.size());
  for (const auto& memory : evidence.evidence.memories) {
    ASSERT_TRUE(grid_.last.contains(memory.track_id)) << "evidence of a track that is gone";
  }
  EXPECT_LE(evidence.frame_indices.size(), static_cast<size_t>(kTrackHistory));
  EXPECT_LE(static_cast<int64_t>(evidence.frame_indices.size()), pictures_);
  if (labels.first_index >= 0) {
    EXPECT_GE(labels.first_index, begin_);
  }
  if (!goes_on) {
    EXPECT_TRUE(evidence.grid.tracks.empty());
    EXPECT_TRUE(evidence.evidence.memories.empty());
  }
}

}  // namespace egosieve::vision
