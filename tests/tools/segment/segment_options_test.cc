#include "tools/segment/segment_options.h"

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "gtest/gtest.h"

namespace egosieve::tools {
namespace {

using Described = std::map<std::string, std::string>;

SegmentSettings Given(const std::vector<std::string>& flags) {
  CLI::App app;
  GivenOptions given;
  given.AddFlags(app);
  app.parse(std::vector<std::string>(flags.rbegin(), flags.rend()));
  return given.MakeSettings();
}

// The options that differ between two runs' descriptions.
Described Difference(const Described& before, const Described& now) {
  Described different;
  for (const auto& [name, value] : now) {
    const auto found = before.find(name);
    if (found == before.end() || found->second != value) different[name] = value;
  }
  return different;
}

// A run of one profile can be told as another with all of its values given.
TEST(SegmentOptions, ReadWhatTheyTell) {
  const SegmentSettings paper = Given({"--profile=paper"}), fast = Given({"--profile=fast"});
  for (const SegmentSettings& target : {paper, fast}) {
    SegmentSettings settings = Given({});
    for (const SegmentOption& option : SegmentOptions()) {
      std::string value = option.get(target);
      if (option.kind == SegmentOption::Kind::kProfile || value.empty() || value == "none")
        continue;
      EXPECT_EQ(option.check(value), "") << option.name;
      option.set(value, settings);
    }
    Described left = Difference(DescribeSettings(target), DescribeSettings(settings));
    for (const SegmentOption& option : SegmentOptions()) {
      if (option.kind == SegmentOption::Kind::kProfile) left.erase(option.name);
    }
    EXPECT_EQ(left, Described());
  }
}

TEST(SegmentOptions, ChangeTheirOwnValueAlone) {
  const Described before = DescribeSettings(Given({}));
  const auto change = [&](const std::string& flag) {
    return Difference(before, DescribeSettings(Given({flag})));
  };
  for (const char* setting : {"seed=7",
                              "stride=2",
                              "budget=300",
                              "ahead=0",
                              "checkpoint_every=0",
                              "from=3",
                              "skip=1",
                              "fps=29.97",
                              "research.inducing_points=64",
                              "research.covariance=matern52",
                              "research.window=5",
                              "research.density=0.1",
                              "research.dynamic_age=9",
                              "research.arrival_share=0.25",
                              "research.novelty_filter=on",
                              "research.consistency_filter=on",
                              "research.zero_label=mean",
                              "research.zero_label=0.2",
                              "research.location_prior=0",
                              "research.label_residual=0",
                              "research.frame_gap=2",
                              "research.labelling_size=0",
                              "research.patch_search=off",
                              "research.focal_ratio=0.8",
                              "research.equalize=clahe"}) {
    const std::pair<std::string, std::string> told =
        absl::StrSplit(absl::StripPrefix(setting, "research."), absl::MaxSplits('=', 1));
    EXPECT_EQ(change(absl::StrCat("--", setting)), Described({told})) << setting;
  }
  EXPECT_EQ(change("--no_own_vehicle"), Described({{"own_vehicle", "off"}}));
  EXPECT_EQ(change("--no_first_pass"), Described({{"first_pass", "off"}}));
  EXPECT_EQ(change("--research.model=exact"),
            Described({{"model", "exact"}, {"inducing_points", "none"}}));
  // A run may be made longer.
  for (const char* flag : {"--to=9", "--max_frames=9", "--camera=a.json"}) {
    EXPECT_EQ(change(flag), Described()) << flag;
  }
}

}  // namespace
}  // namespace egosieve::tools
