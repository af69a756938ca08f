// The build of a program: "commit 1a2b3c4d5e6f, GCC 12.2.0, AVX-512, optimised". The commit is
// known if the build was stamped (`./run` does that); results do not depend on it.
#pragma once

#include <string>

namespace egosieve::tools {

std::string BuildDescription();

}  // namespace egosieve::tools
