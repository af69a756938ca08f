#include "tools/lab/tune_defaults/setting_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ParseGrid, GivesEveryCombinationAfterTheDefaults) {
  const auto settings = ParseGrid("budget=1000,1500; frame_gap=1,2", 10);
  ASSERT_TRUE(settings.ok()) << settings.status();
  ASSERT_EQ(settings->size(), 5u);
  EXPECT_EQ((*settings)[0].name, "as it is");
  EXPECT_TRUE((*settings)[0].flags.empty());
  EXPECT_EQ((*settings)[2].name, "budget=1000,frame_gap=2");
  EXPECT_EQ((*settings)[2].folder, "budget=1000+frame_gap=2");
  EXPECT_THAT((*settings)[4].flags, ElementsAre("--budget=1500", "--frame_gap=2"));
}

TEST(ParseGrid, RefusesWhatIsNoGrid) {
  EXPECT_FALSE(ParseGrid("budget", 10).ok());
  EXPECT_FALSE(ParseGrid("=3", 10).ok());
  EXPECT_FALSE(ParseGrid("a=1,2,3;b=1,2,3,4", 11).ok());
  EXPECT_EQ(ParseGrid("", 10)->size(), 1u);
}

SettingScore Score(const std::string& name, double auc, int failed = 0) {
  return {name, auc, 0.5, auc - 0.2, failed};
}

TEST(RankTable, NoiseDoesNotMoveTheDefaults) {
  const std::string near =
      RankTable({Score("as it is", 0.95), Score("b", 0.955), Score("c", 0.9)}, 0.01);
  EXPECT_THAT(near, HasSubstr("chosen: as it is"));
  EXPECT_LT(near.find("\nb "), near.find("\nas it is "));
  EXPECT_THAT(RankTable({Score("as it is", 0.93), Score("b", 0.94), Score("c", 0.96)}, 0.01),
              HasSubstr("chosen: c"));
}

TEST(RankTable, WhatFailsSomewhereIsNotChosen) {
  EXPECT_THAT(RankTable({Score("as it is", 0.9), Score("b", 0.99, 1)}, 0.01),
              HasSubstr("chosen: as it is"));
  EXPECT_THAT(RankTable({Score("b", 0.99, 1)}, 0.01), HasSubstr("chosen: none"));
}

// Group a has two sequences and b one: each group counts once, "all" not at all.
TEST(ScoreOfSetting, GroupsWeighTheSame) {
  SuiteSummary summary;
  const std::vector<std::pair<std::string, double>> groups = {
      {"a", 0.8}, {"b", 0.6}, {"all", 2.2 / 3.0}};
  for (const auto& [group, mean] : groups) {
    std::vector<std::optional<Spread>> figures(SuiteFigures().size());
    for (auto& figure : figures) figure = Spread{2, mean, {}, 0.5, 0.9};
    summary.figures[{group, "default"}] = figures;
  }
  const SettingScore score = ScoreOfSetting("s", "default", summary);
  EXPECT_NEAR(*score.auc, 0.7, 1e-15);
  EXPECT_EQ(*score.least_auc, 0.5);
  EXPECT_FALSE(ScoreOfSetting("s", "paper", summary).auc.has_value());
}

}  // namespace
}  // namespace egosieve::tools
