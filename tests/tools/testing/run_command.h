// Runs one command as the program would.
#pragma once

#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tools/cli/command_line.h"

namespace egosieve::tools {

struct CommandOutcome {
  int code;
  std::string out, err;  // of the command line; what the command itself prints goes to stdout
};

inline CommandOutcome RunCommandForTest(std::unique_ptr<Command> command,
                                        std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), command->name());
  CommandLine line("egosieve", "", "test");
  line.Add(std::move(command));
  std::ostringstream out, err;
  const int code = line.Run(std::move(arguments), out, err);
  return {code, out.str(), err.str()};
}

}  // namespace egosieve::tools
