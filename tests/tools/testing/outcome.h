// How a program or a command ended.
#pragma once

#include <algorithm>
#include <string>

#include "gmock/gmock.h"

namespace egosieve::tools {

// An exit code, and words on stderr.
MATCHER_P2(Says, code, words, "") {
  *result_listener << "exit code " << arg.code << ": " << arg.err;
  return arg.code == code && arg.err.find(words) != std::string::npos;
}

// The same where they are all of its lines.
MATCHER_P2(EndsWithLine, code, words, "") {
  return testing::ExplainMatchResult(Says(code, words), arg, result_listener) &&
         std::count(arg.err.begin(), arg.err.end(), '\n') == 1;
}

MATCHER(Succeeds, "") {
  *result_listener << "exit code " << arg.code << ": " << arg.err;
  return arg.code == 0;
}

}  // namespace egosieve::tools
