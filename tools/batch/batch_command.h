// egosieve batch INPUT: many drives.
#ifndef EGOSIEVE_TOOLS_BATCH_BATCH_COMMAND_H_
#define EGOSIEVE_TOOLS_BATCH_BATCH_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeBatchCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_BATCH_COMMAND_H_
