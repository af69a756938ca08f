// egosieve segment INPUT --out=DIR: a drive's run folder.
#ifndef EGOSIEVE_TOOLS_SEGMENT_SEGMENT_COMMAND_H_
#define EGOSIEVE_TOOLS_SEGMENT_SEGMENT_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeSegmentCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_SEGMENT_COMMAND_H_
