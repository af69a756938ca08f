#include "tools/batch/manifest.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ManifestTest, JsonAndTomlSayTheSame) {
  const char* json = R"([
    {"path": "a.mp4", "out": "out/a", "flags": {"profile": "fast", "stride": 2, "learn_only": true}},
    {"path": "/b", "out": "/out/b", "flags": {"learn_only": false}}
  ])";
  const char* toml = R"(# Two drives.
[a]
path = "a.mp4"
out = "out/a"
profile = "fast"
stride = 2
learn_only = true

[b]
path = "/b"
out = "/out/b"
learn_only = false
)";
  for (const char* text : {json, toml}) {
    const auto entries = ParseManifest(text, "/drives");
    ASSERT_TRUE(entries.ok()) << entries.status();
    ASSERT_EQ(entries->size(), 2u);
    EXPECT_EQ((*entries)[0].path, "/drives/a.mp4");
    EXPECT_EQ((*entries)[0].out, "/drives/out/a");
    EXPECT_THAT((*entries)[0].flags, ElementsAre("--profile=fast", "--stride=2", "--learn_only"));
    EXPECT_EQ((*entries)[1].path, "/b");
    EXPECT_EQ((*entries)[1].out, "/out/b");
    EXPECT_THAT((*entries)[1].flags, ElementsAre());
  }
}

TEST(ManifestTest, WhatIsWrongIsSaidWithTheEntrysNumber) {
  const auto error = [](const char* text) {
    const auto entries = ParseManifest(text, "");
    EXPECT_EQ(entries.status().code(), absl::StatusCode::kInvalidArgument) << text;
    return std::string(entries.status().message());
  };
  EXPECT_THAT(error(""), HasSubstr("lists no drive"));
  EXPECT_THAT(error("[]"), HasSubstr("lists no drive"));
  EXPECT_THAT(error("[{]"), HasSubstr("not JSON"));
  EXPECT_THAT(error("{\"path\": \"a\"}"), HasSubstr("not a list"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": \"x\"}, 5]"), HasSubstr("entry 2: 5 is not"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": \"x\"}, {\"path\": \"b\"}]"),
              HasSubstr("entry 2: no 'out'"));
  EXPECT_THAT(error("[{\"out\": \"x\"}]"), HasSubstr("entry 1: no 'path'"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": 5}]"), HasSubstr("entry 1: 'out' is not a text"));
  EXPECT_THAT(error("[{\"path\": \"a\", \"out\": \"x\", \"stride\": 2}]"),
              HasSubstr("entry 1: unknown key 'stride'"));
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
              HasSubstr("entry 1: 'stride' has no single value"));
}

}  // namespace
}  // namespace egosieve::tools
