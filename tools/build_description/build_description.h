// What a program was built from and for: "commit 1a2b3c4d5e6f, GCC 12.2.0, AVX-512, optimised".
// The commit is there where the build was stamped (`./run` does); results do not depend on it.
#ifndef EGOSIEVE_TOOLS_BUILD_DESCRIPTION_BUILD_DESCRIPTION_H_
#define EGOSIEVE_TOOLS_BUILD_DESCRIPTION_BUILD_DESCRIPTION_H_

#include <string>

namespace egosieve::tools {

std::string BuildDescription();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BUILD_DESCRIPTION_BUILD_DESCRIPTION_H_
