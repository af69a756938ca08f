#include "tools/batch/manifest.h"

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace egosieve::tools {
namespace {

using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ManifestTest, JsonAndTomlSayTheSame) {
  const char* json = R"([
    {"path": "a.mp4", "out": "out/a", "flags": {"profile": "fast", "stride": 2, "deterministic": true}},
    {"path": "/b", "out": "/out/b", "flags": {"deterministic": false}}
  ])";
  const char* toml = R"(# Two drives.
[a]
path = "a.mp4"
out = "out/a"
profile = "fast"
stride = 2
deterministic = true

[b]
path = "/b"
out = "/out/b"
deterministic = false
)";
  for (const char* text : {json, toml}) {
    const auto entries = ParseManifest(text, "/drives");
    ASSERT_TRUE(entries.ok()) << entries.status();
    ASSERT_EQ(entries->size(), 2u);
    EXPECT_EQ((*entries)[0].path, "/drives/a.mp4");
    EXPECT_EQ((*entries)[0].out, "/drives/out/a");
    EXPECT_THAT((*entries)[0].flags,
                ElementsAre("--profile=fast", "--stride=2", "--deterministic"));
    EXPECT_EQ((*entries)[1].path, "/b");
    EXPECT_EQ((*entries)[1].out, "/out/b");
    EXPECT_THAT((*entries)[1].flags, ElementsAre("--deterministic=false"));
  }
}

TEST(ManifestTest, DefaultsAreSharedAndADriveGoesBeforeThem) {
  const char* toml = R"([defaults]
out = "runs"
then = ["refine", "masks"]
profile = "fast"
deterministic = true
masks.for = "colmap"

[a]
path = "a.mp4"

[b]
path = "b.mp4"
out = "elsewhere/b"
profile = "paper"
deterministic = false
stride = 0.5
then = "report"
)";
  const char* json = R"({"defaults": {"out": "runs", "then": ["refine", "masks"],
      "flags": {"profile": "fast", "deterministic": true}, "masks": {"for": "colmap"}},
    "drives": [{"path": "a.mp4"}, {"path": "b.mp4", "out": "elsewhere/b", "then": "report",
      "flags": {"profile": "paper", "deterministic": false, "stride": 0.5}}]})";
  for (const char* text : {toml, json}) {
    const auto entries = ParseManifest(text, "/drives");
    ASSERT_TRUE(entries.ok()) << entries.status();
    ASSERT_EQ(entries->size(), 2u);
    const BatchEntry& a = (*entries)[0];
    EXPECT_EQ(a.out, "/drives/runs/a");
    EXPECT_THAT(a.flags, ElementsAre("--profile=fast", "--deterministic"));
    ASSERT_EQ(a.then.size(), 2u);
    EXPECT_EQ(a.then[0].command, "refine");
    EXPECT_THAT(a.then[0].flags, ElementsAre());
    EXPECT_EQ(a.then[1].command, "masks");
    EXPECT_THAT(a.then[1].flags, ElementsAre("--for=colmap"));
    const BatchEntry& b = (*entries)[1];
    EXPECT_EQ(b.out, "/drives/elsewhere/b");
    EXPECT_THAT(b.flags, ElementsAre("--profile=paper", "--deterministic=false", "--stride=0.5"));
    ASSERT_EQ(b.then.size(), 1u);
    EXPECT_EQ(b.then[0].command, "report");
  }
}

TEST(ManifestTest, KnowsReconstructAsRefine) {
  const auto entries = ParseManifest(
      "[a]\npath = \"a\"\nout = \"a\"\nthen = \"reconstruct\"\nreconstruct.causal = true\n", "");
  ASSERT_TRUE(entries.ok()) << entries.status();
  ASSERT_EQ((*entries)[0].then.size(), 1u);
  EXPECT_EQ((*entries)[0].then[0].command, "refine");
  EXPECT_THAT((*entries)[0].then[0].flags, ElementsAre("--causal"));
}

// Also what follows, which is refine and report where nothing is said.
TEST(ManifestTest, IsReadAsItIsWritten) {
  const std::vector<BatchEntry> entries = {
      {"/in/a", "/out/a", {"--stride=2", "--deterministic"}, {{"masks", {"--for=coco"}}}, {5, 9}},
      {"/in/b", "/out/b", {}, {}, {}}};
  const auto read = ParseManifest(ToManifest(entries), "/elsewhere");
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ((*read)[i].path, entries[i].path);
    EXPECT_EQ((*read)[i].out, entries[i].out);
    EXPECT_EQ((*read)[i].flags, entries[i].flags);
    EXPECT_EQ((*read)[i].cuts, entries[i].cuts);
  }
  ASSERT_EQ((*read)[0].then.size(), 1u);
  EXPECT_EQ((*read)[0].then[0].command, "masks");
  EXPECT_EQ((*read)[0].then[0].flags, entries[0].then[0].flags);
  EXPECT_TRUE((*read)[1].then.empty());
  const auto bare = ParseManifest("[a]\npath = \"a\"\nout = \"a\"\n", "");
  ASSERT_TRUE(bare.ok()) << bare.status();
  ASSERT_EQ((*bare)[0].then.size(), 2u);
  EXPECT_EQ((*bare)[0].then[0].command, "refine");
}

TEST(ManifestTest, WhatIsGivenGoesBeforeAll) {
  BatchSettings given;
  given.out = "/given";
  given.then = "report";
  given.segment_flags = "--profile=default";
  const auto entries = ParseManifest(
      "[defaults]\nout = \"runs\"\n[a]\npath = \"a\"\nprofile = \"fast\"\nthen = "
      "\"render\"\n[b]\npath = \"b\"\nout = \"own\"\n",
      "/drives", given);
  ASSERT_TRUE(entries.ok()) << entries.status();
  EXPECT_EQ((*entries)[0].out, "/given/a");
  EXPECT_EQ((*entries)[1].out, "/drives/own");
  EXPECT_THAT((*entries)[0].flags, ElementsAre("--profile=default"));
  EXPECT_EQ((*entries)[0].then[0].command, "report");
}

// An array of tables, strings with marks in them, comments and nested keys are TOML, too.
TEST(ManifestTest, TomlIsReadAsItsStandardSays) {
  const auto entries = ParseManifest(R"(
[[drives]]
path = 'C:\a # b.mp4'  # the first
out = """
o"""
[[drives]]
path = "b.mp4"
out = "p"
cuts = [100, 250]
masks = { for = "coco" }
then = [ "masks", ]
)",
                                     "");
  ASSERT_TRUE(entries.ok()) << entries.status();
  EXPECT_EQ((*entries)[0].path, "C:\\a # b.mp4");
  EXPECT_EQ((*entries)[0].out, "o");
  EXPECT_THAT((*entries)[0].cuts, ElementsAre());
  EXPECT_THAT((*entries)[1].cuts, ElementsAre(100, 250));
  EXPECT_THAT((*entries)[1].then[0].flags, ElementsAre("--for=coco"));
}

TEST(ManifestTest, WhatIsWrongIsSaidWithTheEntrysNumber) {
  const auto error = [](const char* text) {
    const auto entries = ParseManifest(text, "");
    EXPECT_EQ(entries.status().code(), absl::StatusCode::kInvalidArgument) << text;
    return std::string(entries.status().message());
  };
  EXPECT_THAT(error(""), HasSubstr("lists no drive"));
  EXPECT_THAT(error("[]"), HasSubstr("lists no drive"));
  EXPECT_THAT(error("[{]"), HasSubstr("neither JSON"));
  EXPECT_THAT(error("{\"drives\": 1e999}"), HasSubstr("neither JSON"));
  EXPECT_THAT(error("{\"path\": \"a\"}"), HasSubstr("outside the tables"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": \"x\"}, 5]"), HasSubstr("entry 2: 5 is not"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": \"x\"}, {\"path\": \"b\"}]"),
              HasSubstr("entry 2: no 'out'"));
  EXPECT_THAT(error("[{\"out\": \"x\"}]"), HasSubstr("entry 1: no 'path'"));
  for (const char* cuts : {"[5, 5]", "[0]", "[\"a\"]", "[1.5]", "{}", "-3"}) {
    const std::string text = absl::StrCat(R"([{"path": "a", "out": "x", "cuts": )", cuts, "}]");
    EXPECT_THAT(error(text.c_str()), HasSubstr("entry 1: 'cuts' is not an ascending")) << cuts;
  }
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": 5}]"), HasSubstr("entry 1: 'out' is not a text"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": \"x\", \"flags\": [2]}]"),
              HasSubstr("entry 1: 'flags' is not an object"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": \"x\", \"flags\": {\"stride\": [1, 2]}}]"),
              HasSubstr("entry 1: the flag 'stride' has no single value"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": \"x\", \"flags\": {\"resume\": true}}]"),
              HasSubstr("entry 1: the flag 'resume' is the batch's own"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": \"x\"}, {\"path\": \"b\", \"out\": \"./x/\"}]"),
              HasSubstr("entry 2: its 'out', x, is that of entry 1"));
  EXPECT_THAT(error("path = \"a\"\nout = \"x\"\n"), HasSubstr("outside the tables"));
  EXPECT_THAT(error("[a]\npath = \"a\"\n"), HasSubstr("entry 1: no 'out'"));
  EXPECT_THAT(error("[a]\npath = \"a\"\nout = \"x\"\nstride = [1, 2]\n"),
              HasSubstr("entry 1: the flag 'stride' has no single value"));
  EXPECT_THAT(error("[a]\npath = a.mp4\n"), ContainsRegex("neither JSON .* nor TOML \\(line 2"));
  EXPECT_THAT(error("[:]\n"), ContainsRegex("neither JSON .* nor TOML \\(line 1"));
  EXPECT_THAT(error("[a]\npath = \"a\"\npath = \"b\"\n"), HasSubstr("line 3"));
  EXPECT_THAT(error("[a]\npath = \"a\"\nout = \"x\"\nthen = \"sing\"\n"),
              HasSubstr("entry 1: then: 'sing' is none of refine"));
  EXPECT_THAT(error("[a]\npath = \"a\"\nout = \"x\"\nsing.loud = true\n"),
              HasSubstr("entry 1: 'sing' has flags"));
  EXPECT_THAT(error("[defaults]\nresume = true\n[a]\npath = \"a\"\nout = \"x\"\n"),
              HasSubstr("defaults: the flag 'resume' is the batch's own"));
  EXPECT_THAT(error("[defaults]\nstride = 2\n"), HasSubstr("lists no drive"));
}

TEST(ManifestTest, GivesResearchSettings) {
  const auto entries = ParseManifest(
      "[a]\npath = 'a.mp4'\nout = 'a'\nstride = 2\n[a.research]\nmodel = 'exact'\nwindow = 5\n",
      "/drives");
  ASSERT_TRUE(entries.ok()) << entries.status();
  EXPECT_THAT(entries->front().flags,
              ElementsAre("--stride=2", "--set=model=exact", "--set=window=5"));
}

}  // namespace
}  // namespace egosieve::tools
