// A flag with a second name that turns it off, --video and --no_video. --print_config, --help and
// the manual tell its default, which CLI11 does not do by itself.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "absl/strings/str_cat.h"

namespace egosieve::tools {

// on, off: the names with their dashes. value: the default before, the wish after the parsing.
inline CLI::Option* AddSwitch(CLI::App& app, const std::string& on, const std::string& off,
                              bool& value, const std::string& description) {
  return app.add_flag(absl::StrCat(on, ",!", off), value, description)
      ->default_str(value ? "true" : "false")
      ->option_text(value ? "(default: on)" : "(default: off)");
}

}  // namespace egosieve::tools
