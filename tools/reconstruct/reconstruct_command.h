// egosieve reconstruct DIR: masks, numbers and tracks of movers (frame_products.h).
#ifndef EGOSIEVE_TOOLS_RECONSTRUCT_RECONSTRUCT_COMMAND_H_
#define EGOSIEVE_TOOLS_RECONSTRUCT_RECONSTRUCT_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeReconstructCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RECONSTRUCT_RECONSTRUCT_COMMAND_H_
