#include "tools/run_folder/baselines.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

Baselines Of(const std::string& features, int near, int far) {
  RunDescription description;
  description.flags["features"] = features;
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
  EXPECT_EQ(Of("auto", 9, 1).far_apart(), 1);
  EXPECT_THAT(Of("auto", 9, 1).Describe(),
              HasSubstr("1 of 10 pairs of pictures lie too far apart"));
  EXPECT_THAT(Of("flow", 0, 4).Describe(), HasSubstr("--from_video"));
}

TEST(Baselines, SayNothingOfCutsNorOfMatchedFeatures) {
  EXPECT_EQ(Of("auto", 10, 1).Describe(), "");
  EXPECT_EQ(Of("auto", 10, 0).Describe(), "");
  EXPECT_EQ(Of("auto", 0, 0).Describe(), "");
  for (const char* features : {"sift+corners", "both", ""}) {
    EXPECT_EQ(Of(features, 0, 5).Describe(), "") << features;
  }
}

}  // namespace
}  // namespace egosieve::tools
