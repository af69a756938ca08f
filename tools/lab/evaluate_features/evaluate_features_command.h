// egosieve lab evaluate_features INPUT: scores of the features' distances and labels, as a table.
#ifndef EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_EVALUATE_FEATURES_COMMAND_H_
#define EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_EVALUATE_FEATURES_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeEvaluateFeaturesCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_EVALUATE_FEATURES_EVALUATE_FEATURES_COMMAND_H_
