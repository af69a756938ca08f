// egosieve lab tune_defaults --suite=A --suite=B --grid=...: finds the settings of segment that are
// best for all sequences. One setting serves all: none depends on a sequence's name.
#ifndef EGOSIEVE_TOOLS_LAB_TUNE_DEFAULTS_TUNE_DEFAULTS_COMMAND_H_
#define EGOSIEVE_TOOLS_LAB_TUNE_DEFAULTS_TUNE_DEFAULTS_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeTuneDefaultsCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_TUNE_DEFAULTS_TUNE_DEFAULTS_COMMAND_H_
