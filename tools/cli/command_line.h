// The program's command line: finds the command, reads its flags, runs it and reports errors.
//
// Every command has --help, --config=FILE (TOML with the names of the flags; unknown keys are
// errors) and --print_config; the program has --man and `completion bash` (manual.h). A group has
// one line in --help, and `egosieve GROUP --help` lists its commands. Errors are one line on
// stderr, and the exit code is ExitCode's.
#ifndef EGOSIEVE_TOOLS_CLI_COMMAND_LINE_H_
#define EGOSIEVE_TOOLS_CLI_COMMAND_LINE_H_

#include <memory>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "tools/cli/command.h"
#include "tools/cli/manual.h"

namespace egosieve::tools {

class CommandLine {
 public:
  // `build`, if not empty, follows the version in the output of --version.
  CommandLine(std::string program, std::string description, std::string version,
              std::string build = "");

  // summary: one sentence.
  void AddGroup(std::string name, std::string summary);
  // group: the name of a group, or "" for a command of the program itself.
  void Add(std::unique_ptr<Command> command, std::string group = "");

  // `arguments` excludes the program's name. Returns the process's exit code, which is not 0 if
  // writing to `out` failed. Never throws.
  int Run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err);

 private:
  int Dispatch(std::vector<std::string> arguments, std::ostream& out, std::ostream& err);
  // Runs the command of the group that the first argument names.
  int RunNamed(const std::string& group, std::vector<std::string> arguments, std::ostream& out,
               std::ostream& err);
  // name: with the program and the group.
  int RunCommand(Command& command, const std::string& name, std::vector<std::string> arguments,
                 std::ostream& out, std::ostream& err);
  // Names and summaries of what may follow the program's name, or the group's.
  std::vector<std::pair<std::string, std::string>> Listed(const std::string& group) const;
  std::string Help(const std::string& group) const;
  // `write` gets the description for a manual; its apps live as long as the call.
  std::string WriteManual(std::string (*write)(const ManualProgram&));
  int TellCompletion(const std::vector<std::string>& arguments, std::ostream& out,
                     std::ostream& err);

  std::string program_;
  std::string description_;
  std::string version_;
  std::string build_;
  std::vector<std::pair<std::string, std::unique_ptr<Command>>> commands_;  // with their groups
  std::vector<std::pair<std::string, std::string>> groups_;                 // name, summary
};

// The candidate nearest to `word` by edit distance, or "" if none is near enough to be a typing
// error.
std::string NearestName(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_COMMAND_LINE_H_
