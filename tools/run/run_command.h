// egosieve run VIDEO: segment, refine, render and report into one folder.
#ifndef EGOSIEVE_TOOLS_RUN_RUN_COMMAND_H_
#define EGOSIEVE_TOOLS_RUN_RUN_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeRunCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_RUN_COMMAND_H_
