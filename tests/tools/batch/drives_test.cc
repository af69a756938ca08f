#include "tools/batch/drives.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/testing/status.h"

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(ParseManifest, DefaultsAreSharedAndADriveGoesBeforeThem) {
  const auto entries = Value(ParseManifest(R"([defaults]
out = "runs"
then = ["refine", "masks"]
profile = "fast"
deterministic = true
masks.for = "colmap"

[a]  # the first
path = "a.mp4"

[b]
path = '/b # c.mp4'
out = "elsewhere/b/"
profile = "paper"
deterministic = false
stride = 0.5
then = "report"
)",
                                           "/drives"));
  ASSERT_EQ(entries.size(), 2u);
  const BatchDrive& a = entries[0];
  EXPECT_EQ(a.path, "/drives/a.mp4");
  EXPECT_EQ(a.out, "/drives/runs/a");
  EXPECT_THAT(a.flags.at("segment"), ElementsAre("--profile=fast", "--deterministic"));
  EXPECT_THAT(a.flags.at("masks"), ElementsAre("--for=colmap"));
  EXPECT_THAT(a.then, ElementsAre("refine", "masks"));
  const BatchDrive& b = entries[1];
  EXPECT_EQ(b.path, "/b # c.mp4");
  EXPECT_EQ(b.out, "/drives/elsewhere/b");
  EXPECT_THAT(b.flags.at("segment"),
              ElementsAre("--profile=paper", "--deterministic=false", "--stride=0.5"));
  EXPECT_THAT(b.then, ElementsAre("report"));
}

TEST(ParseManifest, RefineAndReportFollowWhereNothingIsSaid) {
  const auto entries = Value(ParseManifest("[a]\npath = 'a'\nout = 'a'\n", ""));
  EXPECT_THAT(entries[0].then, ElementsAre("refine", "report"));
}

TEST(ParseManifest, KnowsReconstructAsRefine) {
  const auto entries = Value(ParseManifest(
      "[a]\npath = 'a'\nout = 'a'\nthen = 'reconstruct'\nreconstruct.causal = true\n", ""));
  EXPECT_THAT(entries[0].then, ElementsAre("refine"));
  EXPECT_THAT(entries[0].flags.at("refine"), ElementsAre("--causal"));
}

TEST(ParseManifest, WhatIsGivenGoesBeforeAll) {
  BatchSettings given;
  given.out = "/given";
  given.then = "report";
  given.segment_flags = "--profile=default --set=model=exact";
  const auto entries = Value(
      ParseManifest("[defaults]\nout = \"runs\"\n[a]\npath = \"a\"\nprofile = \"fast\"\nthen = "
                    "\"render\"\n[b]\npath = \"b\"\nout = \"own\"\n",
                    "/drives", given));
  EXPECT_EQ(entries[0].out, "/given/a");
  EXPECT_EQ(entries[1].out, "/drives/own");
  EXPECT_THAT(entries[0].flags.at("segment"),
              ElementsAre("--profile=default", "--set=model=exact"));
  EXPECT_THAT(entries[0].then, ElementsAre("report"));
}

TEST(ParseManifest, GivesCutsAndResearchSettings) {
  const auto entries =
      Value(ParseManifest("[a]\npath = 'a.mp4'\nout = 'a'\ncuts = [100, 250]\nstride = 2\n"
                          "[a.research]\nmodel = 'exact'\nwindow = 5\n",
                          "/drives"));
  EXPECT_THAT(entries.front().cuts, ElementsAre(100, 250));
  EXPECT_THAT(entries.front().flags.at("segment"),
              ElementsAre("--stride=2", "--set=model=exact", "--set=window=5"));
}

TEST(ParseManifest, WhatIsWrongIsSaidWithItsLine) {
  const auto error = [](const std::string& text) {
    const auto entries = ParseManifest(text, "");
    EXPECT_THAT(entries, IsInvalid()) << text;
    return std::string(entries.status().message());
  };
  const std::string whole = "[a]\npath = 'a'\nout = 'x'\n";
  EXPECT_THAT(error(""), HasSubstr("lists no drive"));
  EXPECT_THAT(error("[defaults]\nstride = 2\n"), HasSubstr("lists no drive"));
  EXPECT_THAT(error("[a]\npath = a.mp4\n"), StartsWith("line 2"));
  EXPECT_THAT(error("[:]\n"), StartsWith("line 1"));
  EXPECT_THAT(error("[a]\npath = \"a\"\npath = \"b\"\n"), StartsWith("line 3"));
  EXPECT_THAT(error("path = 'a'\n"), StartsWith("line 1: path: outside the tables"));
  EXPECT_THAT(error("[a]\npath = 'a'\n"), StartsWith("a: no 'out'"));
  EXPECT_THAT(error("[a]\nout = 'a'\n"), StartsWith("a: no 'path'"));
  for (const char* cuts : {"[5, 5]", "[0]", "['a']", "[1.5]", "-3"}) {
    EXPECT_THAT(error(whole + "cuts = " + cuts), HasSubstr("'cuts' is not an ascending")) << cuts;
  }
  EXPECT_THAT(error(whole + "stride = [1, 2]\n"),
              HasSubstr("line 4: a: 'stride' has no single value"));
  EXPECT_THAT(error(whole + "masks.for.us = 1\n"), HasSubstr("'us' has no single value"));
  EXPECT_THAT(error(whole + "then = 'sing'\n"), HasSubstr("'sing' is none of refine"));
  EXPECT_THAT(error(whole + "sing.loud = true\n"), HasSubstr("'sing' is none of refine"));
}

TEST(DriveCuts, AreTheFewestPiecesOfEqualLength) {
  EXPECT_THAT(EqualCuts(3000, 0.1, 5), ElementsAre());
  EXPECT_THAT(EqualCuts(3001, 0.1, 5), ElementsAre(1500));
  EXPECT_THAT(EqualCuts(9001, 0.1, 5), ElementsAre(2250, 4500, 6750));
  EXPECT_THAT(EqualCuts(3, 1.0, 1e-9), ElementsAre(1, 2)) << "no piece is empty";
  EXPECT_THAT(EqualCuts(-1, 0.1, 5), ElementsAre()) << "a length that no header tells";
}

}  // namespace
}  // namespace egosieve::tools
