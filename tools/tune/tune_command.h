// egosieve tune: finds the kernels' best shapes for a device and stores them for later runs.
#ifndef EGOSIEVE_TOOLS_TUNE_TUNE_COMMAND_H_
#define EGOSIEVE_TOOLS_TUNE_TUNE_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeTuneCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_TUNE_TUNE_COMMAND_H_
