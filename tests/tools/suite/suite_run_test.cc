#include "tools/suite/suite_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
