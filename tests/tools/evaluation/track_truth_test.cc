#include "tools/evaluation/track_truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

TEST(TrackTruthTest, PointsByFrame) {
  const TrackTruth truth =
      *ParseTrackTruth("track,label,frame,x,y\n0,1,0,10.5,20\n1,3,0,7,8\r\n0,1,2,11,21\n\n");
  EXPECT_EQ(truth.static_points, 2);
  EXPECT_EQ(truth.dynamic_points, 1);
  ASSERT_EQ(truth.frames.size(), 2u);
  EXPECT_EQ(truth.frames.at(0)[0].x, 10.5);
  EXPECT_FALSE(truth.frames.at(0)[0].dynamic());
  EXPECT_EQ(truth.frames.at(0)[1].label, 3);
  EXPECT_TRUE(truth.frames.at(0)[1].dynamic());
  EXPECT_EQ(truth.frames.at(2)[0].track, 0);
}

TEST(TrackTruthTest, FieldsMayStandInAnyOrder) {
  const TrackTruth truth =
      *ParseTrackTruth("x,y,frame,score,label,track\n1,2,3,0.5,1,9\n4,5,3,0.5,2,8\n");
  EXPECT_EQ(truth.frames.at(3)[0].track, 9);
  EXPECT_EQ(truth.frames.at(3)[1].y, 5.0);
}

TEST(TrackTruthTest, DamageIsNamedByItsLine) {
  const auto message = [](const char* csv) {
    const absl::Status status = ParseTrackTruth(csv).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << csv;
    return std::string(status.message());
  };
  EXPECT_THAT(message(""), HasSubstr("track"));
  EXPECT_THAT(message("track,frame,x,y\n"), HasSubstr("label"));
  EXPECT_THAT(message("track,label,frame,x,y\n0,1,0,1,2\n0,1,0,1\n"), HasSubstr("line 3: no y"));
  EXPECT_THAT(message("track,label,frame,x,y\n0,0,0,1,2\n"), HasSubstr("line 2: label"));
  EXPECT_THAT(message("track,label,frame,x,y\n0,1,-1,1,2\n"), HasSubstr("line 2: frame"));
  EXPECT_THAT(message("track,label,frame,x,y\n0,1,0,nan,2\n"), HasSubstr("line 2: x"));
}

TEST(TrackTruthTest, OneClassIsNoTruth) {
  const absl::Status status = ParseTrackTruth("track,label,frame,x,y\n0,2,0,1,2\n").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("0 static and 1 dynamic"));
}

TEST(TrackTruthTest, ReadsTheSharedClips) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA is not set";
  const absl::StatusOr<TrackTruth> truth =
      ReadTrackTruth(std::string(data) + "/kt3dmoseg/Seq005_Clip01/tracks.csv");
  ASSERT_TRUE(truth.ok()) << truth.status();
  EXPECT_GT(truth->dynamic_points, 100);
  EXPECT_GT(truth->frames.size(), 5u);
  EXPECT_EQ(ReadTrackTruth("/nowhere/tracks.csv").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace egosieve::tools
