// egosieve lab compare: compares the segmenter with other methods on the same features, frames and
// pixels.
#ifndef EGOSIEVE_TOOLS_LAB_COMPARE_COMPARE_COMMAND_H_
#define EGOSIEVE_TOOLS_LAB_COMPARE_COMPARE_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeCompareCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_COMPARE_COMPARE_COMMAND_H_
