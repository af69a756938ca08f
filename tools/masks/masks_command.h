// egosieve masks INPUT|RUN: masks as other programs read them (mask_format.h).
#ifndef EGOSIEVE_TOOLS_MASKS_MASKS_COMMAND_H_
#define EGOSIEVE_TOOLS_MASKS_MASKS_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeMasksCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MASKS_MASKS_COMMAND_H_
