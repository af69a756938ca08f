#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "tools/cli/checks.h"
#include "tools/cli/research_flag.h"
#include "tools/segment/segment_options.h"

namespace egosieve::tools {
namespace {

using vision::OnlineSegmenterOptions;
using Kind = SegmentOption::Kind;

const Words<OnlineSegmenterOptions (*)()>& Profiles() {
  static const auto& words =
      *new Words<OnlineSegmenterOptions (*)()>{{"default", &OnlineSegmenterOptions::Default},
                                               {"paper", &OnlineSegmenterOptions::Paper},
                                               {"fast", &OnlineSegmenterOptions::Fast}};
  return words;
}

SegmentSettings SettingsOf(const std::string& profile) {
  SegmentSettings settings;
  for (const auto& [name, make] : Profiles()) {
    if (name == profile) settings.segmenter = make();
  }
  settings.segmenter.SetSeed(1);
  return settings;
}

// The value if no profile has another; else empty.
std::string CommonDefault(const SegmentOption& option) {
  const std::string value = option.get(SettingsOf("default"));
  for (const auto& [name, make] : Profiles()) {
    if (option.get(SettingsOf(name)) != value) return "";
  }
  return value;
}

}  // namespace

void GivenOptions::AddFlags(CLI::App& app) {
  std::vector<std::string> names;
  for (const SegmentOption& option : SegmentOptions()) {
    if (option.kind != Kind::kProfile) names.push_back(option.name);
  }
  AddFlags(app, names);
  AddSetFlag(app);
}

void GivenOptions::AddFlags(CLI::App& app, const std::vector<std::string>& names) {
  app.add_option("--profile", profile_,
                 "default: the most accurate; paper: as in the paper's sections III to V; fast: "
                 "default with labels from smaller, neighbouring pictures and with fewer inducing "
                 "points. What is given beside it overrides the profile")
      ->check(OneOf(NamesOf(Profiles())))
      ->type_name(absl::StrJoin(NamesOf(Profiles()), "|"));
  for (const SegmentOption& option : SegmentOptions()) {
    if (std::find(names.begin(), names.end(), option.name) == names.end()) continue;
    std::string& given = given_[option.name];
    if (option.type.empty()) {
      const bool is_on = CommonDefault(option) == "on";
      app.add_flag_function(
             absl::StrCat("--", option.name, is_on ? ",!--no_" + option.name : ""),
             [&given](int64_t count) { given = count > 0 ? "on" : "off"; }, option.help)
          ->default_str(is_on ? "true" : "")
          ->option_text(is_on ? "(default: on)" : "");
      continue;
    }
    const bool is_research = option.kind == Kind::kResearch;
    app.add_option_function<std::string>(
           absl::StrCat(is_research ? kResearchFlag : "--", option.name),
           [&given](const std::string& text) { given = text; }, option.help)
        ->check(option.check)
        ->type_name(option.type)
        ->default_str(is_research ? option.get(SettingsOf("default")) : CommonDefault(option))
        ->group(is_research ? kResearchTable : "Options");
  }
}

bool GivenOptions::Has(const std::string& name) const {
  const auto given = given_.find(name);
  return given != given_.end() && !given->second.empty();
}

SegmentSettings GivenOptions::MakeSettings() const {
  SegmentSettings settings = SettingsOf(profile_);
  for (const SegmentOption& option : SegmentOptions()) {
    if (Has(option.name)) option.set(given_.at(option.name), settings);
  }
  return settings;
}

std::map<std::string, std::string> DescribeSettings(const SegmentSettings& settings) {
  std::map<std::string, std::string> described;
  for (const SegmentOption& option : SegmentOptions()) {
    const std::string value = option.get(settings);
    if (option.is_told && !value.empty()) described[option.name] = value;
  }
  return described;
}

}  // namespace egosieve::tools
