#include "tools/suite/suite_run.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"

namespace egosieve::tools {
namespace {

absl::StatusOr<SuiteVariant> ParseVariant(absl::string_view text) {
  const size_t equals = text.find('=');
  const absl::string_view name = text.substr(0, equals);
  const bool is_name = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return absl::ascii_isalnum(c) || c == '_' || c == '-' || c == '+';
  });
  if (equals == absl::string_view::npos || !is_name) {
    return absl::InvalidArgumentError(
        absl::StrCat("variant \"", text,
                     "\" is not NAME=FLAGS, NAME of letters, digits, _, - and +; write, say, "
                     "\"no_road=--evidence=epipolar,negative_depth,three_view,accumulation,"
                     "own_vehicle\""));
  }
  return SuiteVariant{std::string(name),
                      absl::StrSplit(text.substr(equals + 1), ' ', absl::SkipEmpty())};
}

}  // namespace

absl::StatusOr<std::vector<SuiteVariant>> ParseVariants(absl::string_view profiles,
                                                        const std::vector<std::string>& variants) {
  std::vector<SuiteVariant> parsed;
  for (const absl::string_view profile : absl::StrSplit(profiles, ',', absl::SkipEmpty())) {
    parsed.push_back({std::string(profile), {absl::StrCat("--profile=", profile)}});
  }
  for (const std::string& text : variants) {
    EGOSIEVE_ASSIGN_OR_RETURN(SuiteVariant variant, ParseVariant(text));
    parsed.push_back(std::move(variant));
  }
  return parsed;
}

}  // namespace egosieve::tools
