// egosieve merge DIR FROM...: adds the maps, with their lines, of later pieces of the drive.
// Existing contents of DIR stay; the other folders are only read.
#ifndef EGOSIEVE_TOOLS_MERGE_MERGE_COMMAND_H_
#define EGOSIEVE_TOOLS_MERGE_MERGE_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeMergeCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MERGE_MERGE_COMMAND_H_
