#include "tools/suite/suite_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ParseVariant, TakesANameAndFlags) {
  const auto variant = ParseVariant("no_road=--evidence=epipolar,three_view  --budget=500");
  ASSERT_TRUE(variant.ok());
  EXPECT_EQ(variant->name, "no_road");
  EXPECT_THAT(variant->flags, ElementsAre("--evidence=epipolar,three_view", "--budget=500"));
  EXPECT_THAT(ParseVariant("plain=")->flags, ElementsAre());
}

TEST(ParseVariant, RefusesWhatIsNoNameOrNoFolder) {
  for (const char* text : {"", "=--budget=5", "no_flags", "../up=--budget=5", "a b=--budget=5"}) {
    const auto variant = ParseVariant(text);
    EXPECT_EQ(variant.status().code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(variant.status().message()), HasSubstr("NAME=FLAGS"));
  }
}

TEST(ParseVariants, ProfilesComeFirst) {
  const auto variants = ParseVariants("paper,,default", {"few=--budget=5"});
  ASSERT_TRUE(variants.ok()) << variants.status();
  ASSERT_EQ(variants->size(), 3u);
  EXPECT_EQ((*variants)[1].name, "default");
  EXPECT_THAT((*variants)[1].flags, ElementsAre("--profile=default"));
  EXPECT_EQ((*variants)[2].name, "few");
  EXPECT_TRUE(ParseVariants("", {})->empty());
  EXPECT_FALSE(ParseVariants("paper", {"no_flags"}).ok());
}

TEST(RateOf, IsThatOfTheCameraBesideTheFrames) {
  const std::string folder = testing::TempDir() + "/rate";
  std::filesystem::create_directories(folder + "/frames");
  const Sequence sequence{"rate", "rate", folder + "/frames", ""};
  std::filesystem::remove(folder + "/camera.json");
  EXPECT_EQ(*RateOf(sequence), 10.0);
  std::ofstream(folder + "/camera.json")
      << R"({"focal_pixels": 5, "width": 9, "height": 9, "frames_per_second": 30})";
  EXPECT_EQ(*RateOf(sequence), 30.0);
  std::ofstream(folder + "/camera.json") << "{}";
  EXPECT_EQ(RateOf(sequence).status().code(), absl::StatusCode::kDataLoss);
}

TEST(SuiteOptions, VariantsHaveNamesOfTheirOwn) {
  SuiteOptions options;
  options.program = options.out = "somewhere";
  EXPECT_TRUE(options.Validate().ok());
  options.variants.push_back(VariantOfProfile("paper"));
  EXPECT_THAT(std::string(options.Validate().message()), HasSubstr("paper"));
  options.variants.clear();
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace egosieve::tools
