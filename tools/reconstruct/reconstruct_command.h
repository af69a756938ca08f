#ifndef EGOSIEVE_TOOLS_RECONSTRUCT_RECONSTRUCT_COMMAND_H_
#define EGOSIEVE_TOOLS_RECONSTRUCT_RECONSTRUCT_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

// egosieve reconstruct DIR: full/NNNNNN.{prob,std,class}.png from the grid's maps, and the objects
// in them, full/NNNNNN.objects.json.
std::unique_ptr<Command> MakeReconstructCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RECONSTRUCT_RECONSTRUCT_COMMAND_H_
