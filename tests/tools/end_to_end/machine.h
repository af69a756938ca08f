// The program in a shell of its own, where the machine can refuse what it asks for.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "tests/kernels/scoped_variable.h"
#include "tests/testing/fresh_folder.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {

class Machine : public ::testing::Test {
 protected:
  Machine() : root_(FreshFolder()) {}

  // `line` for the shell, where "$EGOSIEVE" is the program.
  ProgramOutcome Shell(const std::string& line) const {
    const std::string err = root_ + "/err.txt";
    setenv("EGOSIEVE", ProgramPath().c_str(), 1);
    const int status = std::system(absl::StrCat("{ ", line, "; } 2> ", err).c_str());
    return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
            .err = *ReadFile(err)};
  }

  static void ExpectOneLine(const ProgramOutcome& outcome, const std::string& what) {
    ExpectErrorLine(outcome, 1, what);
  }

  // Sanitizers need their lines on stderr, and a library that aborts then ends the program.
  static bool ShowsLibraryLines() { return std::getenv("EGOSIEVE_LIBRARY_LINES") != nullptr; }

  std::string root_;

 private:
  ScopedVariable pocl_cache_{"POCL_CACHE_DIR"}, cache_{"EGOSIEVE_CACHE_DIR"};
};

}  // namespace egosieve::tools
