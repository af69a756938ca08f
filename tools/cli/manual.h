// The program's manual page and its completion in shells, made from the flags of its commands, so
// that neither can differ from --help.
#ifndef EGOSIEVE_TOOLS_CLI_MANUAL_H_
#define EGOSIEVE_TOOLS_CLI_MANUAL_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace egosieve::tools {

struct ManualCommand {
  std::string name;
  std::string summary;
  std::string example;            // command lines
  const CLI::App* app = nullptr;  // with the command's flags
};

struct ManualProgram {
  std::string name;
  std::string description;
  std::string version;
  std::vector<ManualCommand> commands;
};

// The exit codes (exit_code.h), a line each: "0    done".
const std::vector<std::pair<int, std::string>>& ExitCodeTexts();

// In man's macros for troff: man 7.
std::string ManualPage(const ManualProgram& program);

// A script for bash that completes commands, flags and the words that a flag takes; where a flag
// takes a file, and for arguments, bash completes files.
std::string BashCompletion(const ManualProgram& program);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_MANUAL_H_
