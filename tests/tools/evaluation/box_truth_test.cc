#include "tools/evaluation/box_truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

constexpr char kHeader[] = "frame,id,type,x1,y1,x2,y2,truncated,occluded,depth,speed,moving\n";

TEST(BoxTruth, FieldsOfEachFrame) {
  const BoxTruth truth =
      *ParseBoxTruth(std::string(kHeader) +
                     "0,7,Van,10.5,20,30,40,1,2,13.5,5.4,1\n3,1,Person,1,2,3,4,,,,,\n"
                     "3,2,DontCare,1,2,3,4,0,0,55,0,0\n");
  ASSERT_EQ(truth.size(), 2u);
  const LabelledBox& van = truth.at(0)[0];
  EXPECT_EQ(van.id, 7);
  EXPECT_EQ(van.box_class, BoxClass::kVehicle);
  EXPECT_EQ(van.left, 10.5);
  EXPECT_EQ(van.bottom, 40.0);
  EXPECT_EQ(van.truncated, 1);
  EXPECT_EQ(van.occluded, 2);
  EXPECT_EQ(van.moving, true);
  EXPECT_STREQ(van.Distance(), "10-20 m");
  ASSERT_EQ(truth.at(3).size(), 2u);
  EXPECT_EQ(truth.at(3)[0].box_class, BoxClass::kPerson);
  EXPECT_FALSE(truth.at(3)[0].moving.has_value());
  EXPECT_STREQ(truth.at(3)[0].Distance(), "unknown");
  EXPECT_EQ(truth.at(3)[1].box_class, BoxClass::kUntold);
  EXPECT_STREQ(truth.at(3)[1].Distance(), "40+ m");
}

TEST(BoxTruth, RangeStandsWhereTheDepthIsUnknown) {
  const BoxTruth truth = *ParseBoxTruth(
      "range,frame,id,type,x1,y1,x2,y2,moving\nnear,0,1,Car,0,0,9,9,1\nfar,0,2,Car,0,0,9,9,0\n");
  EXPECT_STREQ(truth.at(0)[0].Distance(), "near");
  EXPECT_STREQ(truth.at(0)[1].Distance(), "far");
}

TEST(BoxTruth, DamageIsNamedByItsLine) {
  const auto message = [](const std::string& line) {
    const absl::Status status = ParseBoxTruth(kHeader + line).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << line;
    return std::string(status.message());
  };
  EXPECT_THAT(message("0,1,Car,1,2,3\n"), HasSubstr("line 2: no y2"));
  EXPECT_THAT(message("-1,1,Car,1,2,3,4,0,0,5,0,1\n"), HasSubstr("frame is no integer"));
  EXPECT_THAT(message("0,1,Car,1,nan,3,4,0,0,5,0,1\n"), HasSubstr("y1 is no number"));
  EXPECT_THAT(message("0,1,Car,5,2,3,4,0,0,5,0,1\n"), HasSubstr("no area"));
  EXPECT_THAT(message("0,1,Car,1,2,3,4,0,0,5,0,yes\n"), HasSubstr("moving"));
  EXPECT_THAT(std::string(ParseBoxTruth("frame,id\n").status().message()), HasSubstr("type"));
}

TEST(BoxTruth, LabelsDrawnByHandLieInTheirPictures) {
  struct Labels {
    const char* name;
    size_t frames;
    double width, height;
  };
  for (const Labels& labels :
       {Labels{"dashcam_reflections", 12, 640, 360}, {"solidWhiteRight", 6, 960, 540}}) {
    const absl::StatusOr<BoxTruth> truth =
        ReadBoxTruth(std::string("tests/tools/evaluate/labels/") + labels.name + ".csv");
    ASSERT_TRUE(truth.ok()) << truth.status();
    EXPECT_EQ(truth->size(), labels.frames);
    for (const auto& [frame, boxes] : *truth) {
      for (const LabelledBox& box : boxes) {
        EXPECT_GE(box.left, 0.0);
        EXPECT_GE(box.top, 0.0);
        EXPECT_LE(box.right, labels.width - 1.0) << labels.name << " " << frame;
        EXPECT_LE(box.bottom, labels.height - 1.0);
        EXPECT_EQ(box.moving.has_value(), box.box_class == BoxClass::kVehicle);
        EXPECT_EQ(box.range.empty(), box.box_class != BoxClass::kVehicle);
      }
    }
  }
}

TEST(BoxTruth, ReadsTheSharedClips) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA is not set";
  const absl::StatusOr<BoxTruth> truth =
      ReadBoxTruth(std::string(data) + "/kt3dmoseg/Seq005_Clip01/boxes.csv");
  ASSERT_TRUE(truth.ok()) << truth.status();
  EXPECT_EQ(truth->at(0).size(), 3u);
  EXPECT_EQ(ReadBoxTruth("/nowhere/boxes.csv").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace egosieve::tools
