// `egosieve synthesize`: writes a synthetic drive with its truth (synthesize.h).
#ifndef EGOSIEVE_TOOLS_SYNTHESIZE_SYNTHESIZE_COMMAND_H_
#define EGOSIEVE_TOOLS_SYNTHESIZE_SYNTHESIZE_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeSynthesizeCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SYNTHESIZE_SYNTHESIZE_COMMAND_H_
