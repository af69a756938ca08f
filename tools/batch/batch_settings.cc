#include "tools/batch/batch_settings.h"

#include <algorithm>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"

namespace egosieve::tools {
namespace {

using Flags = BatchSettings::Flags;

// Flags that only the batch itself sets.
constexpr const char* kReserved[] = {"out", "resume", "overwrite", "config", "print_config"};

// Adds a flag; a flag that is already there gets the new value.
void SetFlag(const std::string& name, const std::string& value, Flags& flags) {
  const auto found = std::find_if(flags.begin(), flags.end(),
                                  [&](const auto& flag) { return flag.first == name; });
  if (found == flags.end()) {
    flags.emplace_back(name, value);
  } else {
    found->second = value;
  }
}

}  // namespace

const std::vector<std::string>& FollowingCommands() {
  static const auto& commands =
      *new std::vector<std::string>{"infer", "reconstruct", "masks", "render", "report"};
  return commands;
}

absl::StatusOr<std::vector<std::string>> ParseThen(absl::string_view text) {
  std::vector<std::string> words = absl::StrSplit(text, ',', absl::SkipWhitespace());
  for (std::string& word : words) {
    word = std::string(absl::StripAsciiWhitespace(word));
    if (!IsFollowing(word)) {
      return absl::InvalidArgumentError(
          absl::StrCat("then: '", word, "' is none of ", absl::StrJoin(FollowingCommands(), ", ")));
    }
  }
  return words;
}

absl::StatusOr<Flags> ParseFlags(absl::string_view text) {
  Flags flags;
  for (absl::string_view word : absl::StrSplit(text, ' ', absl::SkipEmpty())) {
    if (!absl::ConsumePrefix(&word, "--")) {
      return absl::InvalidArgumentError(
          absl::StrCat("'", word, "' is no flag; write flags as --name=value"));
    }
    const std::vector<std::string> parts = absl::StrSplit(word, absl::MaxSplits('=', 1));
    EGOSIEVE_RETURN_IF_ERROR(
        AddFlag("", parts.front(), parts.size() == 2 ? parts.back() : "true", flags));
  }
  return flags;
}

bool IsFollowing(const std::string& word) {
  const std::vector<std::string>& all = FollowingCommands();
  return std::find(all.begin(), all.end(), word) != all.end();
}

absl::Status Refused(const std::string& where, const std::string& what) {
  return absl::InvalidArgumentError(where.empty() ? what : absl::StrCat(where, ": ", what));
}

absl::Status AddFlag(const std::string& where, const std::string& name, const std::string& value,
                     Flags& flags) {
  for (const char* reserved : kReserved) {
    if (name == reserved) {
      return Refused(where, absl::StrCat("the flag '", name, "' is the batch's own; leave it out"));
    }
  }
  SetFlag(name, value, flags);
  return absl::OkStatus();
}

absl::Status SetThen(const std::string& where, const std::vector<std::string>& words,
                     BatchSettings& settings) {
  const auto then = ParseThen(absl::StrJoin(words, ","));
  if (!then.ok()) return Refused(where, std::string(then.status().message()));
  settings.then = *then;
  settings.says_then = true;
  return absl::OkStatus();
}

void Override(const BatchSettings& later, BatchSettings& settings) {
  if (!later.out.empty()) settings.out = later.out;
  if (later.says_then) {
    settings.then = later.then;
    settings.says_then = true;
  }
  for (const auto& [command, flags] : later.flags) {
    for (const auto& [name, value] : flags) SetFlag(name, value, settings.flags[command]);
  }
}

}  // namespace egosieve::tools
