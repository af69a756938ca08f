#include "tools/run_folder/baselines.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

Baselines Of(const std::string& front_end, int near, int far) {
  RunDescription description;
  description.flags["front_end"] = front_end;
  Baselines baselines(description);
  FrameLine line;
  baselines.Add(line);  // the first frame has no pair
  line.features = 10000;
  for (int i = 0; i < near + far; ++i) {
    line.matches = i < near ? 7000 : 6999;
    baselines.Add(line);
  }
  return baselines;
}

TEST(Baselines, TellARunOfWhichATenthLiesFarApart) {
  EXPECT_EQ(Of("default", 9, 1).far_apart(), 1);
  EXPECT_THAT(Of("default", 9, 1).Describe(),
              HasSubstr("1 of 10 pairs of pictures lie too far apart"));
  EXPECT_THAT(Of("default", 0, 4).Describe(), HasSubstr("--from_video"));
}

TEST(Baselines, SayNothingOfCutsNorOfMatchedFeatures) {
  EXPECT_EQ(Of("default", 10, 1).Describe(), "");
  EXPECT_EQ(Of("default", 10, 0).Describe(), "");
  EXPECT_EQ(Of("default", 0, 0).Describe(), "");
  EXPECT_EQ(Of("paper", 0, 5).Describe(), "");
}

std::string OfNames(const std::vector<std::string>& names, int64_t index_step = 1) {
  Baselines baselines{RunDescription()};
  FrameLine line;
  for (const std::string& name : names) {
    line.image = name;
    baselines.Add(line);
    line.index += index_step;
  }
  return baselines.Describe();
}

TEST(Baselines, TellPicturesChosenFromAVideoByTheirNumbers) {
  EXPECT_THAT(OfNames({"a_0.jpg", "a_6.jpg", "a_12.jpg", "a_18.jpg"}),
              HasSubstr("numbers go up by 6 (a_0.jpg, a_6.jpg)"));
  EXPECT_THAT(OfNames({"cam0/0001.v2", "cam0/0003.v2", "cam0/0005.v2", "cam0/0007.v2"}),
              HasSubstr("numbers go up by 2"));
}

TEST(Baselines, SayNothingOfOtherNames) {
  EXPECT_EQ(OfNames({"0.png", "1.png", "2.png", "3.png"}), "");
  EXPECT_EQ(OfNames({"0.png", "6.png", "12.png"}), "") << "too few to tell";
  EXPECT_EQ(OfNames({"0.png", "6.png", "12.png", "19.png"}), "") << "photographs";
  EXPECT_EQ(OfNames({"0.png", "7.png", "13.png", "19.png"}), "");
  EXPECT_EQ(OfNames({"0.png", "6.png", "a.png", "12.png", "18.png"}), "");
  EXPECT_EQ(OfNames({"", "", "", ""}), "") << "older runs";
  EXPECT_EQ(OfNames({"0.png", "6.png", "12.png", "18.png"}, 6), "") << "a run's own choice";
  EXPECT_EQ(OfNames({"1000.png", "1100.png", "1200.png", "1300.png"}), "") << "milliseconds";
}

}  // namespace
}  // namespace egosieve::tools
