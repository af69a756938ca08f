// egosieve tune_defaults --suite=A --suite=B --grid=...: which settings of segment serve all
// sequences best. One setting for all: none depends on a sequence's name.
#ifndef EGOSIEVE_TOOLS_TUNE_DEFAULTS_TUNE_DEFAULTS_COMMAND_H_
#define EGOSIEVE_TOOLS_TUNE_DEFAULTS_TUNE_DEFAULTS_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeTuneDefaultsCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_TUNE_DEFAULTS_TUNE_DEFAULTS_COMMAND_H_
