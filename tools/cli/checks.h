// Flags as this program has them, and checks of their values, whose errors say which are allowed.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace egosieve::tools {

// A number from `low` to `high`, both included.
template <typename Number>
CLI::Validator Between(Number low, Number high) {
  return CLI::Validator(
      [low, high](std::string& text) {
        Number value;
        if (!CLI::detail::lexical_cast(text, value)) {
          return absl::StrCat("cannot read '", text, "' as a number");
        }
        return value >= low && value <= high
                   ? std::string()
                   : absl::StrCat(text, " is not from ", low, " to ", high);
      },
      "");
}

// A number of at least `low`.
template <typename Number>
CLI::Validator AtLeast(Number low) {
  return CLI::Validator(
      [low](std::string& text) {
        Number value;
        if (!CLI::detail::lexical_cast(text, value)) {
          return absl::StrCat("cannot read '", text, "' as a number");
        }
        return value >= low ? std::string() : absl::StrCat(text, " is less than ", low);
      },
      "");
}

// One of some words.
inline CLI::Validator OneOf(const std::vector<std::string>& words) {
  return CLI::Validator(
      [words](std::string& word) {
        return std::find(words.begin(), words.end(), word) != words.end()
                   ? std::string()
                   : absl::StrCat("'", word, "' is none of ", absl::StrJoin(words, ", "));
      },
      "");
}

// The words that a flag accepts, each with its value.
template <typename Value>
using Words = std::vector<std::pair<std::string, Value>>;

template <typename Value>
std::vector<std::string> NamesOf(const Words<Value>& words) {
  std::vector<std::string> names;
  for (const auto& [name, value] : words) names.push_back(name);
  return names;
}

// Sets `target` to the value of the word given; --help lists the words.
template <typename Value>
CLI::Option* AddWords(CLI::App& app, const std::string& flag, Value& target,
                      const Words<Value>& words, const std::string& description) {
  const std::vector<std::string> names = NamesOf(words);
  std::string initial;
  for (const auto& [name, value] : words) {
    if (value == target) initial = name;
  }
  return app
      .add_option_function<std::string>(
          flag,
          [words, &target](const std::string& given) {
            for (const auto& [name, value] : words) {
              if (name == given) target = value;
            }
          },
          description)
      ->check(OneOf(names))
      ->default_str(initial)
      ->type_name(absl::StrJoin(names, "|"));
}

// A flag with a second name that turns it off, --video and --no_video. --print_config, --help and
// the manual tell its default, which CLI11 does not do by itself.
// on, off: the names with their dashes. value: the default before, the wish after the parsing.
inline CLI::Option* AddSwitch(CLI::App& app, const std::string& on, const std::string& off,
                              bool& value, const std::string& description) {
  return app.add_flag(absl::StrCat(on, ",!", off), value, description)
      ->default_str(value ? "true" : "false")
      ->option_text(value ? "(default: on)" : "(default: off)");
}

}  // namespace egosieve::tools
