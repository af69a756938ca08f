// The flags of a command that were given, so that it can refuse those that the rest of the line
// makes void. A flag with its default value counts as not given: a file that --print_config wrote
// names every flag.
#ifndef EGOSIEVE_TOOLS_CLI_GIVEN_FLAGS_H_
#define EGOSIEVE_TOOLS_CLI_GIVEN_FLAGS_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace egosieve::tools {

inline bool IsGiven(const CLI::Option& option) {
  if (option.count() == 0) return false;
  if (option.get_items_expected_max() == 0) {
    return option.as<bool>() != (option.get_default_str() == "true");
  }
  return absl::StrJoin(option.results(), ",") != option.get_default_str();
}

// Their names, "--out, --jobs"; empty if none is given. For after the parsing.
inline std::string GivenFlags(const std::vector<CLI::Option*>& options) {
  std::string names;
  for (const CLI::Option* option : options) {
    if (IsGiven(*option)) absl::StrAppend(&names, names.empty() ? "" : ", ", option->get_name());
  }
  return names;
}

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_GIVEN_FLAGS_H_
