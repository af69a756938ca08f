// The program's manual page and shell completion. Both are made from the flags of its commands, so
// that they cannot differ from --help.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

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

// The exit codes (exit_code.h), one per line: "0    done".
inline constexpr std::pair<int, const char*> kExitCodeTexts[] = {
    {0, "done"},
    {1, "the device, the disk or memory failed"},
    {2, "usage"},
    {3, "the input cannot be read"},
    {4, "finished with some frames failed, or learnt from fewer than half of them"},
    {130, "interrupted"}};

// The manual page in troff's man macros: man 7.
std::string ManualPage(const ManualProgram& program);

// A bash script that completes commands, flags and the words that a flag accepts. For arguments,
// and flags that take a file, bash completes file names.
std::string BashCompletion(const ManualProgram& program);

}  // namespace egosieve::tools
