// egosieve infer DIR: makes the dense maps that segment left out. On the run's device they equal
// segment's maps byte for byte. On another device they differ by float32's rounding
// (kernels/ops/dense_posterior.h), and their lines name that device.
#ifndef EGOSIEVE_TOOLS_INFER_INFER_COMMAND_H_
#define EGOSIEVE_TOOLS_INFER_INFER_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeInferCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_INFER_COMMAND_H_
