#ifndef EGOSIEVE_TOOLS_INFER_INFER_COMMAND_H_
#define EGOSIEVE_TOOLS_INFER_INFER_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

// egosieve infer RUN: the dense maps of a run that segment left without.
std::unique_ptr<Command> MakeInferCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_INFER_COMMAND_H_
