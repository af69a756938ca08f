// egosieve evaluate DIR --truth=TRUTH: eval.json, eval.csv, and a table.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATE_COMMAND_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATE_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeEvaluateCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATE_COMMAND_H_
