// egosieve model FILE|DIR: prints the contents of a checkpoint, and its points as CSV.
#ifndef EGOSIEVE_TOOLS_MODEL_MODEL_COMMAND_H_
#define EGOSIEVE_TOOLS_MODEL_MODEL_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeModelCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MODEL_MODEL_COMMAND_H_
