// The program's command line: finds the command, reads its flags, runs it and reports errors.
//
// Every command has --help, --config=FILE (TOML with the names of the flags; unknown keys are
// errors) and --print_config; the program has --man and `completion bash` (manual.h). Errors are one
// line on stderr, and the exit code is ExitCode's.
#pragma once

#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "tools/cli/command.h"
#include "tools/cli/manual.h"

namespace egosieve::tools {

class CommandLine {
 public:
  // `build`, if not empty, follows the version in the output of --version.
  CommandLine(std::string program, std::string description, std::string version,
              std::string build = "");

  void Add(std::unique_ptr<Command> command);

  // `arguments` excludes the program's name. Returns the process's exit code, which is not 0 if
  // writing to `out` failed. Never throws.
  int Run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err);

 private:
  int Dispatch(std::vector<std::string> arguments, std::ostream& out, std::ostream& err);
  // name: with the program.
  int RunCommand(Command& command, const std::string& name, std::vector<std::string> arguments,
                 std::ostream& out, std::ostream& err);
  std::string Help() const;
  // `write` gets the description for a manual; its apps live as long as the call.
  std::string WriteManual(std::string (*write)(const ManualProgram&));
  int TellCompletion(const std::vector<std::string>& arguments, std::ostream& out,
                     std::ostream& err);

  std::string program_;
  std::string description_;
  std::string version_;
  std::string build_;
  std::vector<std::unique_ptr<Command>> commands_;
};

}  // namespace egosieve::tools
