// egosieve merge DIR FROM...: the maps that copies of a run folder got on other machines, with
// their lines. What DIR holds stays; the folders that they come from are only read.
#ifndef EGOSIEVE_TOOLS_MERGE_MERGE_COMMAND_H_
#define EGOSIEVE_TOOLS_MERGE_MERGE_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeMergeCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MERGE_MERGE_COMMAND_H_
