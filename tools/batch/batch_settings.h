// Settings for the drives of a batch: run folder, flags of each command, commands that follow.
#ifndef EGOSIEVE_TOOLS_BATCH_BATCH_SETTINGS_H_
#define EGOSIEVE_TOOLS_BATCH_BATCH_SETTINGS_H_

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

// Settings of one drive or of all; an empty field is not set.
struct BatchSettings {
  using Flags = std::vector<std::pair<std::string, std::string>>;  // name, value

  std::string out;
  std::vector<std::string> then;
  bool says_then = false;
  std::map<std::string, Flags> flags;  // by command
};

// The commands that may follow segment.
const std::vector<std::string>& FollowingCommands();

// Words separated by commas. InvalidArgument for a word that is not in FollowingCommands().
absl::StatusOr<std::vector<std::string>> ParseThen(absl::string_view text);
// Parses "--stride=2 --learn_only". InvalidArgument for words that are not flags, and for flags
// that the batch sets itself.
absl::StatusOr<BatchSettings::Flags> ParseFlags(absl::string_view text);

bool IsFollowing(const std::string& word);

// InvalidArgument: "where: what", or "what" if `where` is empty. The setters below use `where` in
// the same way.
absl::Status Refused(const std::string& where, const std::string& what);

// Adds a flag; a flag that is already there gets the new value. InvalidArgument for flags that the
// batch sets itself.
absl::Status AddFlag(const std::string& where, const std::string& name, const std::string& value,
                     BatchSettings::Flags& flags);
absl::Status SetThen(const std::string& where, const std::vector<std::string>& words,
                     BatchSettings& settings);
// Overrides `settings` with the settings that `later` has.
void Override(const BatchSettings& later, BatchSettings& settings);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_BATCH_SETTINGS_H_
