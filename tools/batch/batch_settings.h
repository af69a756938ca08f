// What is said of the drives of a batch: run folder, flags of each command, commands that follow.
#ifndef EGOSIEVE_TOOLS_BATCH_BATCH_SETTINGS_H_
#define EGOSIEVE_TOOLS_BATCH_BATCH_SETTINGS_H_

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

// What is said of drives, one or all; what is not said is empty.
struct BatchSettings {
  using Flags = std::vector<std::pair<std::string, std::string>>;  // name, value

  std::string out;
  std::vector<std::string> then;
  bool says_then = false;
  std::map<std::string, Flags> flags;  // by command
};

// The commands that may follow segment.
const std::vector<std::string>& FollowingCommands();

// Words by commas. InvalidArgument for one that is none of FollowingCommands().
absl::StatusOr<std::vector<std::string>> ParseThen(absl::string_view text);
// "--stride=2 --learn_only". InvalidArgument for words that are no flags, and for flags that the
// batch sets itself.
absl::StatusOr<BatchSettings::Flags> ParseFlags(absl::string_view text);

bool IsFollowing(const std::string& word);

// InvalidArgument: "where: what"; without "where: " where that is empty. The setters below name
// `where` likewise.
absl::Status Refused(const std::string& where, const std::string& what);

// A flag that is there already gets the later value. InvalidArgument for flags that the batch sets
// itself.
absl::Status AddFlag(const std::string& where, const std::string& name, const std::string& value,
                     BatchSettings::Flags& flags);
absl::Status SetThen(const std::string& where, const std::vector<std::string>& words,
                     BatchSettings& settings);
// `settings`, overridden by what `later` says.
void Override(const BatchSettings& later, BatchSettings& settings);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_BATCH_SETTINGS_H_
