// The tree that `./run install` makes, in a folder of the test's own, and programs run as in a
// shell that knows nothing of this repository.
#pragma once

#include <string>

namespace egosieve::embed {

struct CommandOutcome {
  int code = -1;       // exit code, or 128 + the signal that ended it
  std::string output;  // stdout and stderr together
};

// A shell's command line, in `folder`, with no environment but HOME, PATH, EGOSIEVE_DEVICE and
// `variables` ("A=1 B=2").
CommandOutcome RunClean(const std::string& folder, const std::string& command,
                        const std::string& variables = "");

// Whether the clean shell finds a program.
bool HasProgram(const std::string& name);

// The folder of the tree, unpacked once a process. Empty, and the calling test fails, where that
// goes wrong.
const std::string& InstalledTree();

// Where the tree's Python modules lie.
std::string InstalledPythonFolder();

// True where the libraries were built with a sanitizer: plain programs cannot load them.
bool IsInstrumented();

// A new empty folder of the test's.
std::string NewFolder(const std::string& name);

}  // namespace egosieve::embed
