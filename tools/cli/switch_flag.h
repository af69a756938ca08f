// A flag that is on unless its second name turns it off, --video and --no_video. CLI11 does not
// tell its default to --print_config, where it would be off.
#ifndef EGOSIEVE_TOOLS_CLI_SWITCH_FLAG_H_
#define EGOSIEVE_TOOLS_CLI_SWITCH_FLAG_H_

#include <CLI/CLI.hpp>
#include <string>

#include "absl/strings/str_cat.h"

namespace egosieve::tools {

// on, off: the names with their dashes. value: the default before, the wish after the parsing.
inline CLI::Option* AddSwitch(CLI::App& app, const std::string& on, const std::string& off,
                              bool& value, const std::string& description) {
  return app.add_flag(absl::StrCat(on, ",!", off), value, description)
      ->default_str(value ? "true" : "false");
}

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_SWITCH_FLAG_H_
