// egosieve devices: lists the devices for --device=.
#ifndef EGOSIEVE_TOOLS_DEVICES_DEVICES_COMMAND_H_
#define EGOSIEVE_TOOLS_DEVICES_DEVICES_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeDevicesCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_DEVICES_DEVICES_COMMAND_H_
