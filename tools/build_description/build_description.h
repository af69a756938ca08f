// The build of a program: "commit 1a2b3c4d5e6f, GCC 12.2.0, AVX-512, optimised". The commit is
// known if the build was stamped (`./run` does that); results do not depend on it.
#ifndef EGOSIEVE_TOOLS_BUILD_DESCRIPTION_BUILD_DESCRIPTION_H_
#define EGOSIEVE_TOOLS_BUILD_DESCRIPTION_BUILD_DESCRIPTION_H_

#include <string>

namespace egosieve::tools {

std::string BuildDescription();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BUILD_DESCRIPTION_BUILD_DESCRIPTION_H_
