// Research settings of a command: the table [research] of --config, and --set NAME=VALUE. To CLI11
// each is a flag of its own, --research.NAME, in a group that --help does not list.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace egosieve::tools {

inline constexpr char kSetFlag[] = "--set";
inline constexpr char kResearchTable[] = "research";
inline constexpr char kResearchFlag[] = "--research.";

// Once for a command that has such settings.
inline void AddSetFlag(CLI::App& app) {
  app.add_option(kSetFlag,
                 "A research setting, as the table [research] of --config has them; --print_config "
                 "lists all. May be repeated")
      ->type_name("NAME=VALUE")
      ->configurable(false);
}

// Leaves the settings out of what lists flags.
inline void HideSettings(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_group() == kResearchTable) option->group("");
  }
}

}  // namespace egosieve::tools
