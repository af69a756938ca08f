#include "tools/segment/segment_options.h"

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

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
  const std::map<std::string, Described> changes = {
      {"--seed=7", {{"seed", "7"}}},
      {"--stride=2", {{"stride", "2"}}},
      {"--budget=300", {{"budget", "300"}}},
      {"--ahead=0", {{"ahead", "0"}}},
      {"--no_own_vehicle", {{"own_vehicle", "off"}}},
      {"--no_first_pass", {{"first_pass", "off"}}},
      {"--checkpoint_every=0", {{"checkpoint_every", "0"}}},
      {"--from=3", {{"from", "3"}}},
      {"--skip=1", {{"skip", "1"}}},
      {"--fps=29.97", {{"fps", "29.97"}}},
      {"--to=9", {}},          // a run may be made longer
      {"--max_frames=9", {}},  // likewise
      {"--camera=a.json", {}},
      {"--research.model=exact", {{"model", "exact"}, {"inducing_points", "none"}}},
      {"--research.inducing_points=64", {{"inducing_points", "64"}}},
      {"--research.covariance=matern52", {{"covariance", "matern52"}}},
      {"--research.window=5", {{"window", "5"}}},
      {"--research.density=0.1", {{"density", "0.1"}}},
      {"--research.dynamic_age=9", {{"dynamic_age", "9"}}},
      {"--research.arrival_share=0.25", {{"arrival_share", "0.25"}}},
      {"--research.novelty_filter=on", {{"novelty_filter", "on"}}},
      {"--research.consistency_filter=on", {{"consistency_filter", "on"}}},
      {"--research.zero_label=mean", {{"zero_label", "mean"}}},
      {"--research.zero_label=0.2", {{"zero_label", "0.2"}}},
      {"--research.location_prior=0", {{"location_prior", "0"}}},
      {"--research.label_residual=0", {{"label_residual", "0"}}},
      {"--research.evidence=epipolar", {{"evidence", "epipolar"}}},
      {"--research.frame_gap=2", {{"frame_gap", "2"}}},
      {"--research.labelling_size=0", {{"labelling_size", "0"}}},
      {"--research.patch_search=off", {{"patch_search", "off"}}},
      {"--research.focal_ratio=0.8", {{"focal_ratio", "0.8"}}},
      {"--research.equalize=clahe", {{"equalize", "clahe"}}},
  };
  for (const auto& [flag, change] : changes) {
    EXPECT_EQ(Difference(before, DescribeSettings(Given({flag}))), change) << flag;
  }
}

}  // namespace
}  // namespace egosieve::tools
